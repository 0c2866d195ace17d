// SPDX-License-Identifier: Apache-2.0
// Internal to this module (includes libtorch): a batch's way through a network and its gradients' way back.
#pragma once

#include "ndg/neural/adamw.h"
#include "ndg/neural/torch_network.h"

#include <torch/types.h>

#include <vector>

namespace ndg {

/// The same sums as TorchNetwork::forward. The matrices' part is done by hand: their products may be of bfloat16
/// copies, and their gradients are handed on block by block instead of being stored. What lies between two matrices
/// (LayerNorm, GELU, dropout) is left to autograd.
class TrainingPass {
public:
    /// `precision` of products, resolved. Gradients are handed on as those of parameters from `first_parameter` on.
    /// Keeps a reference.
    TrainingPass(TorchNetwork& network, Precision precision, LastLayer last = LastLayer::outputs,
                 int first_parameter = 0);

    /// What products read in place of each of TorchNetwork::parameters: bfloat16 copies of matrices; undefined where
    /// they read the parameter.
    const std::vector<torch::Tensor>& copies() const { return copies_; }
    /// Makes the copies equal to the parameters again, after those were set.
    void refresh_copies();

    /// (B, inputs) to raw outputs or coefficients, a leaf of autograd that gathers the gradient for backward.
    torch::Tensor forward(const torch::Tensor& inputs, double dropout);
    /// From the gradient of what the last forward gave. The sink may change a parameter when it takes its gradient.
    void backward(const torch::Tensor& output_gradient, GradientSink& sink);

private:
    struct Stage {
        int parameter = 0;     ///< of the layer's matrix; bias, norm_weight and norm_bias follow
        torch::Tensor input;   ///< as multiplied
        torch::Tensor sums;    ///< weight input + bias
        torch::Tensor output;  ///< after LayerNorm, GELU and dropout; undefined in the last layer
    };
    torch::Tensor as_factor(const torch::Tensor& values) const;
    const torch::Tensor& matrix(std::size_t layer_idx) const;
    /// Hands on the gradient of a layer's matrix, given that of its sums, and returns that of its input (undefined for
    /// the first layer).
    torch::Tensor matrix_backward(std::size_t layer_idx, const torch::Tensor& gradient, GradientSink& sink) const;

    TorchNetwork& network_;
    Precision precision_;
    int first_parameter_;
    std::vector<torch::Tensor> copies_;
    torch::Tensor basis_;  ///< as multiplied; undefined where coefficients are asked for
    std::vector<Stage> stages_;
};

}  // namespace ndg
