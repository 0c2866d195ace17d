// SPDX-License-Identifier: Apache-2.0
// Internal to this module (includes libtorch): all of a model's network, one perceptron or one a region.
#pragma once

#include "ndg/neural/adamw.h"
#include "ndg/neural/body_regions.h"
#include "ndg/neural/torch_network.h"
#include "ndg/neural/training_pass.h"

#include <torch/types.h>

#include <vector>

namespace ndg {

/// Perceptrons side by side, each of which sees some columns of the inputs and gives some of the outputs.
struct Network {
    struct Part {
        TorchNetwork perceptron;
        torch::Tensor inputs, outputs;  ///< columns, int64; undefined: all, of the only part there is
    };
    std::vector<Part> parts;
    std::int64_t num_outputs = 0;

    /// Of all parts, in their order.
    std::vector<torch::Tensor> parameters() const;
    /// Of all parts that have one.
    std::vector<torch::Tensor> bases() const;
    /// (B, inputs) to raw outputs (B, num_outputs), or to what the last layers give, part by part. Not differentiable.
    torch::Tensor forward(const torch::Tensor& inputs, LastLayer last = LastLayer::outputs) const;
    void to(Device device);
    /// With parameters of its own and the same bases.
    Network clone() const;
};

/// One perceptron for each of `columns`, or one for all inputs and outputs where that is empty; `bases`: of each, empty
/// or without rows: none. Weights as make_perceptron makes them.
Network make_network(const std::vector<int>& widths, int num_inputs, int num_outputs,
                     const std::vector<NetworkColumns>& columns, const std::vector<RowMatrixF>& bases,
                     std::uint64_t seed);

/// TrainingPass through all parts.
class NetworkPass {
public:
    /// Keeps a reference.
    NetworkPass(Network& network, Precision precision, LastLayer last);

    /// As those of TrainingPass, for Network::parameters.
    std::vector<torch::Tensor> copies() const;
    void refresh_copies();
    /// As Network::forward, a leaf of autograd.
    torch::Tensor forward(const torch::Tensor& inputs, double dropout);
    void backward(const torch::Tensor& output_gradient, GradientSink& sink);

private:
    /// Calls f(part) for all parts; of several, each on one thread, where a part alone would share its own small work.
    template <typename F>
    void for_parts(bool in_any_order, const F& f) const;

    Network& network_;
    LastLayer last_;
    std::vector<TrainingPass> passes_;
};

}  // namespace ndg
