// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/adamw.h"

#include <cmath>
#include <utility>

namespace ndg {
namespace {

constexpr double beta_1 = 0.9, beta_2 = 0.999, epsilon = 1e-8;

/// What is the same for all entries of a step.
struct StepFactors {
    float decay;      ///< of the parameter
    float step;       ///< learning rate over the first moment's bias correction
    float inv_scale;  ///< one over the square root of the second moment's bias correction
};

void update_on_cpu(torch::Tensor& parameter, const torch::Tensor& gradient, torch::Tensor& first, torch::Tensor& second,
                   const StepFactors& factors)
{
    const torch::Tensor contiguous = gradient.contiguous();
    const float* g = contiguous.data_ptr<float>();
    float* p = parameter.data_ptr<float>();
    float* m = first.data_ptr<float>();
    float* v = second.data_ptr<float>();
    const std::int64_t count = parameter.numel();
    constexpr auto b1 = static_cast<float>(beta_1);
    constexpr auto b2 = static_cast<float>(beta_2);
    constexpr auto rest1 = static_cast<float>(1 - beta_1);
    constexpr auto rest2 = static_cast<float>(1 - beta_2);
    constexpr auto eps = static_cast<float>(epsilon);
#pragma omp parallel for simd schedule(static)
    for (std::int64_t i = 0; i < count; ++i) {
        m[i] = b1 * m[i] + rest1 * g[i];
        v[i] = b2 * v[i] + rest2 * g[i] * g[i];
        p[i] = p[i] * factors.decay - factors.step * m[i] / (std::sqrt(v[i]) * factors.inv_scale + eps);
    }
}

void update_on_device(torch::Tensor& parameter, const torch::Tensor& gradient, torch::Tensor& first,
                      torch::Tensor& second, const StepFactors& factors)
{
    first.mul_(beta_1).add_(gradient, 1 - beta_1);
    second.mul_(beta_2).addcmul_(gradient, gradient, 1 - beta_2);
    parameter.mul_(factors.decay).addcdiv_(first, second.sqrt().mul_(factors.inv_scale).add_(epsilon), -factors.step);
}

}  // namespace

AdamW::AdamW(std::vector<torch::Tensor> parameters, double weight_decay)
    : parameters_(std::move(parameters)), weight_decay_(weight_decay)
{
    for (const torch::Tensor& parameter : parameters_) {
        first_moments.push_back(torch::zeros_like(parameter, torch::TensorOptions().requires_grad(false)));
        second_moments.push_back(torch::zeros_like(parameter, torch::TensorOptions().requires_grad(false)));
    }
}

void AdamW::step(double learning_rate)
{
    const torch::NoGradGuard no_grad;
    ++num_steps;
    const auto t = static_cast<double>(num_steps);
    for (std::size_t i = 0; i < parameters_.size(); ++i) {
        torch::Tensor& parameter = parameters_[i];
        if (!parameter.grad().defined()) continue;
        const double decay = parameter.dim() > 1 ? 1 - learning_rate * weight_decay_ : 1.0;
        const StepFactors factors{static_cast<float>(decay),
                                  static_cast<float>(learning_rate / (1 - std::pow(beta_1, t))),
                                  static_cast<float>(1 / std::sqrt(1 - std::pow(beta_2, t)))};
        const auto update = parameter.device().is_cpu() ? update_on_cpu : update_on_device;
        update(parameter, parameter.grad(), first_moments[i], second_moments[i], factors);
        parameter.mutable_grad() = torch::Tensor();
    }
}

}  // namespace ndg
