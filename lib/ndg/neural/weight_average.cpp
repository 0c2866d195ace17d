// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/weight_average.h"

#include <algorithm>

namespace ndg {

WeightAverage::WeightAverage(const Network& network, double decay)
    : network_(network), average_(network.clone()), decay_(decay)
{
}

void WeightAverage::update(std::int64_t num_steps)
{
    const torch::NoGradGuard no_grad;
    const auto t = static_cast<double>(num_steps);
    const double kept = std::min(decay_, t / (t + 9));
    const std::vector<torch::Tensor> averages = average_.parameters(), parameters = network_.parameters();
    for (std::size_t i = 0; i < averages.size(); ++i) torch::Tensor(averages[i]).lerp_(parameters[i], 1 - kept);
}

}  // namespace ndg
