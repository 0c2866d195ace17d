// SPDX-License-Identifier: Apache-2.0
// Internal to this module (includes libtorch): averages of a network's weights over the steps of its training.
#pragma once

#include "ndg/neural/network.h"

#include <torch/types.h>

#include <vector>

namespace ndg {

/// The exponential moving average of all parameters (Polyak and Juditsky 1992, as it is used today). At step t the
/// decay is at most t / (t + 9), so that the first steps, far from where training ends, are soon forgotten.
class WeightAverage {
public:
    /// Of `network`, whose parameters it starts from and of which it keeps a reference. `decay` a step.
    WeightAverage(const Network& network, double decay);

    /// After step number `num_steps` = 1, 2, ...
    void update(std::int64_t num_steps);
    /// With the averages as its parameters.
    const Network& network() const { return average_; }
    /// To be kept in a checkpoint and set when it is resumed, in the order of Network::parameters.
    std::vector<torch::Tensor> parameters() const { return average_.parameters(); }

private:
    const Network& network_;
    Network average_;
    double decay_;
};

}  // namespace ndg
