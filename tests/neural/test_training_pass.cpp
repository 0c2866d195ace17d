// SPDX-License-Identifier: Apache-2.0
// A step's gradients against finite differences and libtorch's own, and the optimizer that takes them.
#include "ndg/neural/training_pass.h"

#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/core/threads.h"
#include "ndg/core/types.h"
#include "ndg/neural/matrix_product.h"
#include "ndg/neural/parametrisation.h"

#include <torch/optim/adamw.h>

#include <vector>

// libtorch's logging macros share names with Catch2.
#undef CHECK
#include <catch2/catch.hpp>

using namespace ndg;
using torch::Tensor;

namespace {

Tensor random_tensor(std::int64_t rows, std::int64_t columns, double scale, std::uint64_t index)
{
    Random random(5, "training pass", index);
    Tensor tensor = torch::empty({rows, columns});
    for (std::int64_t i = 0; i < tensor.numel(); ++i)
        tensor.data_ptr<float>()[i] = static_cast<float>(scale * random.normal());
    return tensor;
}

/// Two hidden layers, its last layer away from zero; the outputs are 70 matrices a sample.
TorchNetwork some_network(bool with_basis)
{
    RowMatrixF basis;
    if (with_basis) {
        const Tensor values = random_tensor(12, 630, 0.1, 1);
        basis = Eigen::Map<const RowMatrixF>(values.data_ptr<float>(), 12, 630);
    }
    TorchNetwork network = make_perceptron({40, 24}, 19, 630, basis, 3);
    const torch::NoGradGuard no_grad;
    Tensor& last = network.layers.back().weight;
    last.copy_(random_tensor(last.size(0), last.size(1), 0.1, 2));
    return network;
}

/// Keeps what it is given.
class KeptGradients : public GradientSink {
public:
    explicit KeptGradients(const std::vector<Tensor>& parameters)
    {
        for (const Tensor& parameter : parameters)
            gradients.push_back(torch::full_like(parameter, 1e9, torch::TensorOptions().requires_grad(false)));
    }
    void take(int parameter, std::int64_t first, std::int64_t count, const float* gradient) override
    {
        std::copy_n(gradient, count, gradients[parameter].data_ptr<float>() + first);
    }
    void take(int parameter, const Tensor& gradient) override { gradients[parameter].copy_(gradient); }

    std::vector<Tensor> gradients;
};

struct Case {
    TorchNetwork network;
    Tensor inputs = random_tensor(7, 19, 1.0, 3);
    Tensor targets = random_tensor(7, 630, 0.3, 4);

    explicit Case(bool with_basis) : network(some_network(with_basis)) {}

    Tensor loss(const Tensor& outputs) const
    {
        const Tensor residuals = differentiable_exponential(outputs.reshape({7, -1, 9})).reshape(outputs.sizes());
        return torch::mse_loss(residuals, targets);
    }
    std::vector<Tensor> gradients(Precision precision)
    {
        TrainingPass pass(network, precision);
        KeptGradients kept(network.parameters());
        const Tensor outputs = pass.forward(inputs, 0);
        loss(outputs).backward();
        pass.backward(outputs.grad(), kept);
        return kept.gradients;
    }
    /// libtorch's forward and autograd, in double precision where asked.
    double reference_loss() const
    {
        const torch::NoGradGuard no_grad;
        Tensor x = inputs.to(torch::kFloat64);
        for (const TorchNetwork::Layer& layer : network.layers) {
            x = torch::linear(x, layer.weight.to(torch::kFloat64), layer.bias.to(torch::kFloat64));
            if (!layer.norm_weight.defined()) continue;
            x = torch::gelu(torch::layer_norm(x, {x.size(1)}, layer.norm_weight.to(torch::kFloat64),
                                              layer.norm_bias.to(torch::kFloat64)));
        }
        if (network.basis.defined()) x = torch::matmul(x, network.basis.to(torch::kFloat64));
        const Tensor residuals = torch::matrix_exp(x.reshape({-1, 3, 3})).reshape({7, 630});
        return torch::mse_loss(residuals, targets.to(torch::kFloat64)).item<double>();
    }
};

}  // namespace

TEST_CASE("gradients of the whole network agree with finite differences")
{
    for (const bool with_basis : {false, true}) {
        CAPTURE(with_basis);
        Case c(with_basis);
        const std::vector<Tensor> gradients = c.gradients(Precision::float32);
        const std::vector<Tensor> parameters = c.network.parameters();
        const torch::NoGradGuard no_grad;
        for (std::size_t i = 0; i < parameters.size(); ++i) {
            // Along a random direction: every entry counts.
            const Tensor direction =
                random_tensor(1, parameters[i].numel(), 1.0, 100 + i).reshape(parameters[i].sizes());
            const Tensor start = parameters[i].clone();
            const double step = 2e-4;
            parameters[i].copy_(start + step * direction);
            const double after = c.reference_loss();
            parameters[i].copy_(start - step * direction);
            const double before = c.reference_loss();
            parameters[i].copy_(start);
            const double expected = (after - before) / (2 * step);
            const double actual = (gradients[i] * direction).sum().item<double>();
            const double size = gradients[i].norm().item<double>();
            CAPTURE(i, expected, actual, size);
            CHECK(size > 0);
            CHECK(std::abs(actual - expected) < 2e-3 * size);
        }
    }
}

TEST_CASE("the network's float32 forward is that of a training pass")
{
    Case c(false);
    TrainingPass pass(c.network, Precision::float32);
    CHECK(torch::equal(pass.forward(c.inputs, 0).detach(), c.network.forward(c.inputs)));
}

TEST_CASE("bfloat16 products leave gradients within their rounding")
{
    try {
        resolve_precision(Precision::bfloat16, Device::cpu);
    } catch (const InputError& error) {
        // Not on this processor; then nothing else chooses it either.
        CHECK(std::string(error.what()).find("AVX-512") != std::string::npos);
        CHECK(resolve_precision(Precision::automatic, Device::cpu) == Precision::float32);
        return;
    }
    for (const bool with_basis : {false, true}) {
        Case c(with_basis);
        const std::vector<Tensor> exact = c.gradients(Precision::float32), rounded = c.gradients(Precision::bfloat16);
        for (std::size_t i = 0; i < exact.size(); ++i) {
            const double difference = ((exact[i] - rounded[i]).norm() / exact[i].norm()).item<double>();
            CAPTURE(with_basis, i, difference);
            CHECK(difference < 0.02);  // 2^-9 a factor, through three layers and back
            CHECK(difference > 0);
        }
    }
}

TEST_CASE("products are those of libtorch, transposed or not, on any number of threads")
{
    const Tensor a = random_tensor(33, 70, 1.0, 10), b = random_tensor(70, 45, 1.0, 11);
    for (const int threads : {1, 2}) {
        set_num_threads(threads);
        CHECK((product(a, b) - torch::mm(a, b)).abs().max().item<double>() < 1e-4);
        CHECK((product(a.t().contiguous().t(), b) - torch::mm(a, b)).abs().max().item<double>() < 1e-4);
        CHECK((product(a, b.t().contiguous().t()) - torch::mm(a, b)).abs().max().item<double>() < 1e-4);
        CHECK((product(a.narrow(0, 3, 1), b) - torch::mm(a.narrow(0, 3, 1), b)).abs().max().item<double>() < 1e-4);
    }
    set_num_threads(1);
    CHECK_THROWS(product(a, a));
}

TEST_CASE("AdamW takes the steps of torch::optim::AdamW and keeps its copy")
{
    const Tensor start = random_tensor(12, 15, 1.0, 20), target = random_tensor(12, 15, 2.0, 21);
    Tensor ours = start.clone(), copy = start.to(torch::kBFloat16), theirs = start.clone().requires_grad_();
    AdamW optimizer({ours}, {copy}, 0.1);
    torch::optim::AdamW reference({theirs}, torch::optim::AdamWOptions(0.02).weight_decay(0.1));
    for (int step = 0; step < 30; ++step) {
        const Tensor gradient = 2 * (ours - target) / 180;
        optimizer.begin_step(0.02);
        if (step % 2 == 0) {
            optimizer.take(0, gradient);
        } else {  // in two parts, the second first
            optimizer.take(0, 100, 80, gradient.data_ptr<float>() + 100);
            optimizer.take(0, 0, 100, gradient.data_ptr<float>());
        }
        reference.zero_grad();
        (theirs - target).square().mean().backward();
        reference.step();
        CHECK(torch::equal(copy, ours.to(torch::kBFloat16)));
    }
    CHECK((ours - start).abs().max().item<double>() > 0.1);
    CHECK((ours - theirs).abs().max().item<double>() < 1e-5);
    CHECK(optimizer.num_steps == 30);
}
