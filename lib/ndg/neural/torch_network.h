// SPDX-License-Identifier: Apache-2.0
// Internal to this module (includes libtorch): the multilayer perceptron of NDG section 4.4.
#pragma once

#include "ndg/core/types.h"
#include "ndg/neural/options.h"

#include <torch/types.h>

#include <cstdint>
#include <vector>

namespace ndg {

/// exp of each 3 x 3 block of a (..., 9) float tensor, differentiable. Our own kernel on the CPU, where
/// torch::matrix_exp takes ten times as long and more; torch::matrix_exp elsewhere.
torch::Tensor differentiable_exponential(const torch::Tensor& matrices);

struct TorchNetwork {
    /// out = weight in + bias, then LayerNorm with norm_weight and norm_bias (undefined in the last layer), then GELU.
    struct Layer {
        torch::Tensor weight, bias, norm_weight, norm_bias;
    };
    std::vector<Layer> layers;  ///< hidden layers and the last one
    torch::Tensor basis;        ///< k x 9 N_p, not trained; undefined where the last layer gives Q itself
    ParametrisationKind parametrisation = ParametrisationKind::exponential;

    /// Trained tensors in a fixed order.
    std::vector<torch::Tensor> parameters() const;
    /// (B, inputs) to residuals (B, 9 N_p). Dropout with this probability, drawn from torch's generator; 0 in use.
    torch::Tensor forward(const torch::Tensor& inputs, double dropout) const;
    void to(Device device);
    /// float32 copy on the CPU.
    static RowMatrixF matrix(const torch::Tensor& tensor);
};

/// Hidden weights and biases uniform in +-1/sqrt(inputs) from ndg::Random, the last layer zero: the network starts as
/// the identity residual, that is, at gradient skinning. With options.output_basis > 0 the last layer has as many
/// outputs as `basis` has rows.
TorchNetwork make_network(const NetworkOptions& options, int num_inputs, int num_prisms, const RowMatrixF& basis,
                          std::uint64_t seed);

torch::Tensor tensor_from(const Eigen::Ref<const RowMatrixF>& matrix);
torch::DeviceType torch_device(Device device);

}  // namespace ndg
