// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/torch_network.h"

#include "ndg/core/random.h"
#include "ndg/neural/matrix_exponential.h"

#include <torch/csrc/autograd/custom_function.h>

#include <cmath>

namespace ndg {
namespace {

using torch::Tensor;

std::size_t num_matrices(const Tensor& tensor)
{
    return static_cast<std::size_t>(tensor.numel() / 9);
}

struct ExponentialFunction : torch::autograd::Function<ExponentialFunction> {
    static Tensor forward(torch::autograd::AutogradContext* context, const Tensor& matrices)
    {
        const Tensor input = matrices.contiguous();
        Tensor output = torch::empty_like(input);
        matrix_exponential(input.data_ptr<float>(), num_matrices(input), output.data_ptr<float>());
        context->save_for_backward({input});
        return output;
    }

    static torch::autograd::tensor_list backward(torch::autograd::AutogradContext* context,
                                                 torch::autograd::tensor_list gradients)
    {
        const Tensor input = context->get_saved_variables()[0];
        const Tensor gradient = gradients[0].contiguous();
        Tensor result = torch::empty_like(input);
        matrix_exponential_adjoint(input.data_ptr<float>(), gradient.data_ptr<float>(), num_matrices(input),
                                   result.data_ptr<float>());
        return {result};
    }
};

/// exp(Q00) Q01 Q02; 0 exp(Q11) Q12; 0 0 exp(Q22), given the nine entries of Q.
Tensor positive_upper_triangular(const std::vector<Tensor>& q)
{
    const Tensor zero = torch::zeros_like(q[0]);
    return torch::stack({q[0].exp(), q[1], q[2], zero, q[4].exp(), q[5], zero, zero, q[8].exp()}, -1);
}

Tensor product(const Tensor& a, const Tensor& b)
{
    return torch::bmm(a.reshape({-1, 3, 3}), b.reshape({-1, 3, 3})).reshape(a.sizes());
}

/// Q (B, 9 N_p) to residuals of the same shape.
Tensor parametrise(const Tensor& outputs, ParametrisationKind parametrisation)
{
    const Tensor matrices = outputs.reshape({outputs.size(0), -1, 9});
    Tensor residuals;
    if (parametrisation == ParametrisationKind::exponential) {
        residuals = differentiable_exponential(matrices);
    } else if (parametrisation == ParametrisationKind::direct) {
        residuals = matrices + torch::eye(3, outputs.options()).reshape({1, 1, 9});
    } else {
        const std::vector<Tensor> q = matrices.unbind(-1);
        const Tensor zero = torch::zeros_like(q[0]);
        const Tensor one = torch::ones_like(q[0]);
        const Tensor left = parametrisation == ParametrisationKind::lu
                                ? torch::stack({one, zero, zero, q[3], one, zero, q[6], q[7], one}, -1)
                                : differentiable_exponential(
                                      torch::stack({zero, -q[3], -q[6], q[3], zero, -q[7], q[6], q[7], zero}, -1));
        residuals = product(left, positive_upper_triangular(q));
    }
    return residuals.reshape(outputs.sizes());
}

Tensor uniform_tensor(std::vector<std::int64_t> shape, double bound, Random& random)
{
    Tensor tensor = torch::empty(shape, torch::kFloat32);
    float* data = tensor.data_ptr<float>();
    for (std::int64_t i = 0; i < tensor.numel(); ++i) data[i] = static_cast<float>(random.uniform(-bound, bound));
    return tensor;
}

}  // namespace

torch::Tensor differentiable_exponential(const torch::Tensor& matrices)
{
    if (matrices.device().is_cpu()) return ExponentialFunction::apply(matrices);
    return torch::matrix_exp(matrices.reshape({-1, 3, 3})).reshape(matrices.sizes());
}

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

torch::Tensor TorchNetwork::forward(const torch::Tensor& inputs, double dropout) const
{
    Tensor x = inputs;
    for (const Layer& layer : layers) {
        x = torch::linear(x, layer.weight, layer.bias);
        if (!layer.norm_weight.defined()) continue;
        x = torch::gelu(torch::layer_norm(x, {x.size(1)}, layer.norm_weight, layer.norm_bias));
        if (dropout > 0) x = torch::dropout(x, dropout, true);
    }
    if (basis.defined()) x = torch::matmul(x, basis);
    return parametrise(x, parametrisation);
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

TorchNetwork make_network(const NetworkOptions& options, int num_inputs, int num_prisms, const RowMatrixF& basis,
                          std::uint64_t seed)
{
    TorchNetwork network;
    network.parametrisation = options.parametrisation;
    if (options.output_basis > 0) network.basis = tensor_from(basis);
    std::int64_t inputs = num_inputs;
    for (std::size_t i = 0; i < options.widths.size(); ++i) {
        const std::int64_t outputs = options.widths[i];
        Random random(seed, "network layer", i);
        const double bound = 1.0 / std::sqrt(static_cast<double>(inputs));
        TorchNetwork::Layer layer;
        layer.weight = uniform_tensor({outputs, inputs}, bound, random);
        layer.bias = uniform_tensor({outputs}, bound, random);
        layer.norm_weight = torch::ones({outputs});
        layer.norm_bias = torch::zeros({outputs});
        network.layers.push_back(layer);
        inputs = outputs;
    }
    const std::int64_t outputs = options.output_basis > 0 ? basis.rows() : 9 * static_cast<std::int64_t>(num_prisms);
    network.layers.push_back({torch::zeros({outputs, inputs}), torch::zeros({outputs}), Tensor(), Tensor()});
    for (Tensor& parameter : network.parameters()) parameter.requires_grad_();
    return network;
}

}  // namespace ndg
