// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/network.h"

#include "ndg/core/parallel_for.h"

namespace ndg {
namespace {

using torch::Tensor;

/// Seeds of a part's layers begin so many after those of the part before.
constexpr int most_layers = 32;

Tensor column_tensor(const std::vector<int>& columns)
{
    Tensor tensor = torch::empty({static_cast<std::int64_t>(columns.size())}, torch::kInt64);
    std::copy(columns.begin(), columns.end(), tensor.data_ptr<std::int64_t>());
    return tensor;
}

Tensor select(const Tensor& matrix, const Tensor& columns)
{
    return columns.defined() ? matrix.index_select(1, columns) : matrix;
}

/// What the parts give, side by side: in the columns of the outputs, or part by part.
Tensor join(const Network& network, const std::vector<Tensor>& given, LastLayer last)
{
    if (given.size() == 1 && !network.parts[0].outputs.defined()) return given[0];
    if (last == LastLayer::coefficients) return torch::cat(given, 1);
    Tensor outputs = torch::zeros({given[0].size(0), network.num_outputs}, given[0].options());
    for (std::size_t i = 0; i < given.size(); ++i) outputs.index_copy_(1, network.parts[i].outputs, given[i]);
    return outputs;
}

}  // namespace

std::vector<Tensor> Network::parameters() const
{
    std::vector<Tensor> all;
    for (const Part& part : parts)
        for (const Tensor& parameter : part.perceptron.parameters()) all.push_back(parameter);
    return all;
}

std::vector<Tensor> Network::bases() const
{
    std::vector<Tensor> all;
    for (const Part& part : parts)
        if (part.perceptron.basis.defined()) all.push_back(part.perceptron.basis);
    return all;
}

Tensor Network::forward(const Tensor& inputs, LastLayer last) const
{
    const torch::NoGradGuard no_grad;
    std::vector<Tensor> given;
    for (const Part& part : parts) given.push_back(part.perceptron.forward(select(inputs, part.inputs), last));
    return join(*this, given, last);
}

void Network::to(Device device)
{
    for (Part& part : parts) {
        part.perceptron.to(device);
        for (Tensor* columns : {&part.inputs, &part.outputs})
            if (columns->defined()) *columns = columns->to(torch_device(device));
    }
}

Network Network::clone() const
{
    Network copy = *this;
    for (Part& part : copy.parts)
        for (TorchNetwork::Layer& layer : part.perceptron.layers)
            for (Tensor* tensor : {&layer.weight, &layer.bias, &layer.norm_weight, &layer.norm_bias})
                if (tensor->defined()) *tensor = tensor->detach().clone();
    return copy;
}

Network make_network(const std::vector<int>& widths, int num_inputs, int num_outputs,
                     const std::vector<NetworkColumns>& columns, const std::vector<RowMatrixF>& bases,
                     std::uint64_t seed)
{
    const auto basis = [&](std::size_t part) { return bases.empty() ? RowMatrixF() : bases[part]; };
    Network network;
    network.num_outputs = num_outputs;
    if (columns.empty())
        network.parts.push_back({make_perceptron(widths, num_inputs, num_outputs, basis(0), seed), {}, {}});
    for (std::size_t i = 0; i < columns.size(); ++i)
        network.parts.push_back(
            {make_perceptron(widths, static_cast<int>(columns[i].inputs.size()),
                             static_cast<int>(columns[i].outputs.size()), basis(i), seed, most_layers * i),
             column_tensor(columns[i].inputs), column_tensor(columns[i].outputs)});
    return network;
}

NetworkPass::NetworkPass(Network& network, Precision precision, LastLayer last) : network_(network), last_(last)
{
    int first_parameter = 0;
    for (Network::Part& part : network.parts) {
        passes_.emplace_back(part.perceptron, precision, last, first_parameter);
        first_parameter += static_cast<int>(part.perceptron.parameters().size());
    }
}

std::vector<Tensor> NetworkPass::copies() const
{
    std::vector<Tensor> all;
    for (const TrainingPass& pass : passes_) all.insert(all.end(), pass.copies().begin(), pass.copies().end());
    return all;
}

void NetworkPass::refresh_copies()
{
    for (TrainingPass& pass : passes_) pass.refresh_copies();
}

template <typename F>
void NetworkPass::for_parts(bool in_any_order, const F& f) const
{
    const auto count = static_cast<int>(passes_.size());
    if (count > 1 && in_any_order && network_.parts[0].inputs.is_cpu()) {
        parallel_for(count, f);
        return;
    }
    for (int i = 0; i < count; ++i) f(i);
}

Tensor NetworkPass::forward(const Tensor& inputs, double dropout)
{
    std::vector<Tensor> given(passes_.size());
    const auto forward_part = [&](int i) {
        given[i] = passes_[i].forward(select(inputs, network_.parts[i].inputs), dropout).detach();
    };
    for_parts(dropout == 0, forward_part);  // dropout draws from one generator, in the order of the parts
    return join(network_, given, last_).requires_grad_();
}

void NetworkPass::backward(const Tensor& output_gradient, GradientSink& sink)
{
    std::vector<Tensor> gradients;
    std::int64_t first = 0;
    for (const Network::Part& part : network_.parts) {
        const std::int64_t count = part.perceptron.num_coefficients();
        gradients.push_back(last_ == LastLayer::coefficients && part.outputs.defined()
                                ? output_gradient.narrow(1, first, count)
                                : select(output_gradient, part.outputs));
        first += count;
    }
    for_parts(true, [&](int i) { passes_[i].backward(gradients[i], sink); });
}

}  // namespace ndg
