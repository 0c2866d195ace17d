// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/training_pass.h"

#include "ndg/core/parallel_for.h"
#include "ndg/neural/matrix_product.h"

#include <torch/autograd.h>

#include <algorithm>
#include <vector>

namespace ndg {
namespace {

using torch::Tensor;

/// Entries of a matrix whose gradients are made and used together: 512 KiB of each, so that they stay in the second
/// cache.
constexpr std::int64_t block_entries = 1 << 17;
constexpr int max_parts = 16;  ///< of a matrix that threads share

}  // namespace

TrainingPass::TrainingPass(TorchNetwork& network, Precision precision, LastLayer last, int first_parameter)
    : network_(network), precision_(precision), first_parameter_(first_parameter)
{
    const torch::NoGradGuard no_grad;
    const std::vector<Tensor> parameters = network.parameters();
    copies_.resize(parameters.size());
    if (precision == Precision::bfloat16)
        for (std::size_t i = 0; i < parameters.size(); ++i)
            if (parameters[i].dim() > 1) copies_[i] = parameters[i].to(torch::kBFloat16);
    if (network.basis.defined() && last == LastLayer::outputs) basis_ = as_factor(network.basis);
    int parameter = first_parameter;
    for (const TorchNetwork::Layer& layer : network.layers) {
        stages_.push_back({parameter, {}, {}, {}});
        parameter += layer.norm_weight.defined() ? 4 : 2;
    }
}

void TrainingPass::refresh_copies()
{
    const torch::NoGradGuard no_grad;
    const std::vector<Tensor> parameters = network_.parameters();
    for (std::size_t i = 0; i < parameters.size(); ++i)
        if (copies_[i].defined()) copies_[i].copy_(parameters[i]);
}

Tensor TrainingPass::as_factor(const Tensor& values) const
{
    return precision_ == Precision::bfloat16 ? values.to(torch::kBFloat16) : values;
}

const Tensor& TrainingPass::matrix(std::size_t layer_idx) const
{
    const Tensor& copy = copies_[stages_[layer_idx].parameter - first_parameter_];
    return copy.defined() ? copy : network_.layers[layer_idx].weight;
}

Tensor TrainingPass::forward(const Tensor& inputs, double dropout)
{
    Tensor x = inputs;
    for (std::size_t i = 0; i < stages_.size(); ++i) {
        const TorchNetwork::Layer& layer = network_.layers[i];
        Stage& stage = stages_[i];
        {
            const torch::NoGradGuard no_grad;
            stage.input = as_factor(x.detach());
            stage.sums = product(stage.input, matrix(i).t()).add_(layer.bias);
        }
        x = stage.sums;
        if (!layer.norm_weight.defined()) continue;
        x = stage.output = TorchNetwork::activate(layer, stage.sums.requires_grad_(), dropout);
    }
    if (basis_.defined()) x = product(as_factor(x), basis_);
    return x.requires_grad_();
}

Tensor TrainingPass::matrix_backward(std::size_t layer_idx, const Tensor& gradient, GradientSink& sink) const
{
    const Stage& stage = stages_[layer_idx];
    const Tensor& weight = matrix(layer_idx);
    const Tensor factor = as_factor(gradient).contiguous(), transposed = factor.t().contiguous();
    if (!gradient.device().is_cpu()) {
        const Tensor of_input = layer_idx > 0 ? product(factor, weight) : Tensor();
        sink.take(stage.parameter, product(transposed, stage.input));
        return of_input;
    }
    // Block by block: while its rows lie in the cache the matrix is used for the gradient of the input and then moved
    // by its own. Parts add up for themselves, as many whatever the number of threads.
    const std::int64_t rows = weight.size(0), columns = weight.size(1), batch = gradient.size(0);
    const std::int64_t block = std::max<std::int64_t>(16, block_entries / columns / 16 * 16);
    const std::int64_t num_blocks = (rows + block - 1) / block;
    const auto num_parts = static_cast<int>(std::min<std::int64_t>(max_parts, num_blocks));
    Tensor of_input;
    if (layer_idx > 0) of_input = torch::empty({num_parts, batch, columns});
    parallel_for(num_parts, [&](int part) {
        thread_local std::vector<float> buffer;
        const std::int64_t begin = part * num_blocks / num_parts * block;
        const std::int64_t end = std::min(rows, (part + 1) * num_blocks / num_parts * block);
        for (std::int64_t first = begin; first < end; first += block) {
            const std::int64_t count = std::min(block, end - first);
            if (of_input.defined())
                product(factor.narrow(1, first, count), weight.narrow(0, first, count),
                        of_input.data_ptr<float>() + part * batch * columns,
                        first == begin ? Into::replace : Into::add);
            buffer.resize(static_cast<std::size_t>(count * columns));
            product(transposed.narrow(0, first, count), stage.input, buffer.data());
            sink.take(stage.parameter, first * columns, count * columns, buffer.data());
        }
    });
    return of_input.defined() ? of_input.sum(0) : of_input;
}

void TrainingPass::backward(const Tensor& output_gradient, GradientSink& sink)
{
    const torch::NoGradGuard no_grad;
    Tensor gradient = output_gradient;
    if (basis_.defined()) gradient = product(as_factor(gradient), basis_.t());
    for (std::size_t i = stages_.size(); i-- > 0;) {
        const TorchNetwork::Layer& layer = network_.layers[i];
        Stage& stage = stages_[i];
        if (stage.output.defined()) {
            const std::vector<Tensor> gradients =
                torch::autograd::grad({stage.output}, {stage.sums, layer.norm_weight, layer.norm_bias}, {gradient});
            gradient = gradients[0];
            sink.take(stage.parameter + 2, gradients[1]);
            sink.take(stage.parameter + 3, gradients[2]);
        }
        sink.take(stage.parameter + 1, gradient.sum(0));
        gradient = matrix_backward(i, gradient, sink);
        stage.output = Tensor();
    }
}

}  // namespace ndg
