// SPDX-License-Identifier: Apache-2.0
// Internal to this module (includes libtorch): AdamW (Loshchilov and Hutter 2019).
#pragma once

#include <torch/types.h>

#include <cstdint>
#include <vector>

namespace ndg {

/// The update of torch::optim::AdamW (beta 0.9 and 0.999, epsilon 1e-8), in one pass over the memory on the CPU, with
/// its whole state in plain tensors. Weight decay acts on matrices only.
class AdamW {
public:
    AdamW(std::vector<torch::Tensor> parameters, double weight_decay);

    /// One step from the parameters' gradients, which are cleared.
    void step(double learning_rate);

    std::int64_t num_steps = 0;
    std::vector<torch::Tensor> first_moments, second_moments;

private:
    std::vector<torch::Tensor> parameters_;
    double weight_decay_;
};

}  // namespace ndg
