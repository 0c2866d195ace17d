// SPDX-License-Identifier: Apache-2.0
// Internal to this module (includes libtorch): the multilayer perceptron of NDG section 4.4.
#pragma once

#include "ndg/core/types.h"
#include "ndg/neural/options.h"

#include <torch/types.h>

#include <cstdint>
#include <vector>

namespace ndg {

/// What is asked of a perceptron with a basis: raw outputs, or the coefficients that its last layer gives.
enum class LastLayer { outputs, coefficients };

struct TorchNetwork {
    /// out = weight in + bias, then LayerNorm with norm_weight and norm_bias (undefined in the last layer), then GELU.
    struct Layer {
        torch::Tensor weight, bias, norm_weight, norm_bias;
    };
    std::vector<Layer> layers;  ///< hidden layers and the last one
    torch::Tensor basis;        ///< k x outputs, not trained; undefined where the last layer gives the outputs itself

    /// Trained tensors in a fixed order.
    std::vector<torch::Tensor> parameters() const;
    /// Numbers that the last layer gives.
    std::int64_t num_coefficients() const { return layers.back().bias.size(0); }
    /// (B, inputs) to raw outputs (B, outputs), or to (B, num_coefficients), in float32. Not differentiable:
    /// TrainingPass is.
    torch::Tensor forward(const torch::Tensor& inputs, LastLayer last = LastLayer::outputs) const;
    /// What follows the matrix of a hidden layer, differentiable: LayerNorm, GELU and dropout with this probability,
    /// drawn from torch's generator.
    static torch::Tensor activate(const Layer& layer, const torch::Tensor& sums, double dropout);
    void to(Device device);
    /// float32 copy on the CPU.
    static RowMatrixF matrix(const torch::Tensor& tensor);
};

/// Hidden weights and biases uniform in +-1/sqrt(inputs) from ndg::Random, the last layer zero: the raw outputs start
/// as zero. `basis` (k x outputs) is put behind the last layer, which then has k outputs; without rows: no basis.
/// Layers draw from the seed's streams from `first_stream` on.
TorchNetwork make_perceptron(const std::vector<int>& widths, int num_inputs, int num_outputs, const RowMatrixF& basis,
                             std::uint64_t seed, std::uint64_t first_stream = 0);

torch::Tensor tensor_from(const Eigen::Ref<const RowMatrixF>& matrix);
torch::DeviceType torch_device(Device device);

}  // namespace ndg
