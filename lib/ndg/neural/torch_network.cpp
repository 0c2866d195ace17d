// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/torch_network.h"

#include "ndg/core/random.h"
#include "ndg/neural/matrix_product.h"

#include <cmath>

namespace ndg {
namespace {

using torch::Tensor;

Tensor uniform_tensor(std::vector<std::int64_t> shape, double bound, Random& random)
{
    Tensor tensor = torch::empty(shape, torch::kFloat32);
    float* data = tensor.data_ptr<float>();
    for (std::int64_t i = 0; i < tensor.numel(); ++i) data[i] = static_cast<float>(random.uniform(-bound, bound));
    return tensor;
}

}  // namespace

torch::DeviceType torch_device(Device device)
{
    return device == Device::cuda ? torch::kCUDA : torch::kCPU;
}

torch::Tensor tensor_from(const Eigen::Ref<const RowMatrixF>& matrix)
{
    Tensor tensor = torch::empty({matrix.rows(), matrix.cols()}, torch::kFloat32);
    Eigen::Map<RowMatrixF>(tensor.data_ptr<float>(), matrix.rows(), matrix.cols()) = matrix;
    return tensor;
}

RowMatrixF TorchNetwork::matrix(const torch::Tensor& tensor)
{
    const Tensor flat = tensor.detach().to(torch::kCPU).contiguous();
    const Eigen::Index rows = flat.dim() > 1 ? flat.size(0) : 1;
    return Eigen::Map<const RowMatrixF>(flat.data_ptr<float>(), rows, flat.numel() / rows);
}

std::vector<torch::Tensor> TorchNetwork::parameters() const
{
    std::vector<Tensor> all;
    for (const Layer& layer : layers)
        for (const Tensor& tensor : {layer.weight, layer.bias, layer.norm_weight, layer.norm_bias})
            if (tensor.defined()) all.push_back(tensor);
    return all;
}

torch::Tensor TorchNetwork::activate(const Layer& layer, const torch::Tensor& sums, double dropout)
{
    const Tensor x = torch::gelu(torch::layer_norm(sums, {sums.size(1)}, layer.norm_weight, layer.norm_bias));
    return dropout > 0 ? torch::dropout(x, dropout, true) : x;
}

torch::Tensor TorchNetwork::forward(const torch::Tensor& inputs, LastLayer last) const
{
    const torch::NoGradGuard no_grad;
    Tensor x = inputs;
    for (const Layer& layer : layers) {
        x = product(x, layer.weight.t()).add_(layer.bias);
        if (layer.norm_weight.defined()) x = activate(layer, x, 0);
    }
    return basis.defined() && last == LastLayer::outputs ? product(x, basis) : x;
}

void TorchNetwork::to(Device device)
{
    const torch::NoGradGuard no_grad;
    const auto move = [&](Tensor& tensor) {
        if (!tensor.defined()) return;
        const bool trained = tensor.requires_grad();
        tensor = tensor.detach().to(torch_device(device)).requires_grad_(trained);
    };
    for (Layer& layer : layers)
        for (Tensor* tensor : {&layer.weight, &layer.bias, &layer.norm_weight, &layer.norm_bias}) move(*tensor);
    move(basis);
}

TorchNetwork make_perceptron(const std::vector<int>& widths, int num_inputs, int num_outputs, const RowMatrixF& basis,
                             std::uint64_t seed, std::uint64_t first_stream)
{
    TorchNetwork network;
    if (basis.rows() > 0) network.basis = tensor_from(basis);
    std::int64_t inputs = num_inputs;
    for (std::size_t i = 0; i < widths.size(); ++i) {
        const std::int64_t outputs = widths[i];
        Random random(seed, "network layer", first_stream + i);
        const double bound = 1.0 / std::sqrt(static_cast<double>(inputs));
        TorchNetwork::Layer layer;
        layer.weight = uniform_tensor({outputs, inputs}, bound, random);
        layer.bias = uniform_tensor({outputs}, bound, random);
        layer.norm_weight = torch::ones({outputs});
        layer.norm_bias = torch::zeros({outputs});
        network.layers.push_back(layer);
        inputs = outputs;
    }
    const std::int64_t outputs = basis.rows() > 0 ? basis.rows() : num_outputs;
    network.layers.push_back({torch::zeros({outputs, inputs}), torch::zeros({outputs}), Tensor(), Tensor()});
    for (Tensor& parameter : network.parameters()) parameter.requires_grad_();
    return network;
}

}  // namespace ndg
