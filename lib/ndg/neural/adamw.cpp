// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/adamw.h"

#include <cmath>
#include <cstring>
#include <utility>

namespace ndg {
namespace {

constexpr double beta_1 = 0.9, beta_2 = 0.999, epsilon = 1e-8;

/// Nearest, ties to even; of finite numbers.
std::uint16_t bfloat16_bits(float value)
{
    std::uint32_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    return static_cast<std::uint16_t>((bits + 0x7fffu + ((bits >> 16) & 1u)) >> 16);
}

/// `copy` (bfloat16): null where there is none.
void update_entries(float* p, float* m, float* v, std::uint16_t* copy, const float* g, std::int64_t count, float decay,
                    float step, float inv_scale)
{
    constexpr auto b1 = static_cast<float>(beta_1);
    constexpr auto b2 = static_cast<float>(beta_2);
    constexpr auto rest1 = static_cast<float>(1 - beta_1);
    constexpr auto rest2 = static_cast<float>(1 - beta_2);
    constexpr auto eps = static_cast<float>(epsilon);
    const auto update = [=](std::int64_t i) {
        m[i] = b1 * m[i] + rest1 * g[i];
        v[i] = b2 * v[i] + rest2 * g[i] * g[i];
        p[i] = p[i] * decay - step * m[i] / (std::sqrt(v[i]) * inv_scale + eps);
    };
    if (!copy) {
#pragma omp simd
        for (std::int64_t i = 0; i < count; ++i) update(i);
        return;
    }
#pragma omp simd
    for (std::int64_t i = 0; i < count; ++i) {
        update(i);
        copy[i] = bfloat16_bits(p[i]);
    }
}

}  // namespace

AdamW::AdamW(std::vector<torch::Tensor> parameters, std::vector<torch::Tensor> copies, double weight_decay)
    : parameters_(std::move(parameters)), copies_(std::move(copies)), weight_decay_(weight_decay)
{
    copies_.resize(parameters_.size());
    for (const torch::Tensor& parameter : parameters_) {
        first_moments.push_back(torch::zeros_like(parameter, torch::TensorOptions().requires_grad(false)));
        second_moments.push_back(torch::zeros_like(parameter, torch::TensorOptions().requires_grad(false)));
    }
}

float AdamW::decay_of(const torch::Tensor& parameter) const
{
    return parameter.dim() > 1 ? static_cast<float>(1 - factors_.rate * weight_decay_) : 1.0f;
}

void AdamW::begin_step(double learning_rate)
{
    ++num_steps;
    const auto t = static_cast<double>(num_steps);
    factors_ = {static_cast<float>(learning_rate), static_cast<float>(learning_rate / (1 - std::pow(beta_1, t))),
                static_cast<float>(1 / std::sqrt(1 - std::pow(beta_2, t)))};
}

void AdamW::take(int parameter, std::int64_t first, std::int64_t count, const float* gradient)
{
    const torch::Tensor& copy = copies_[parameter];
    std::uint16_t* copied = copy.defined() ? static_cast<std::uint16_t*>(copy.data_ptr()) + first : nullptr;
    update_entries(parameters_[parameter].data_ptr<float>() + first, first_moments[parameter].data_ptr<float>() + first,
                   second_moments[parameter].data_ptr<float>() + first, copied, gradient, count,
                   decay_of(parameters_[parameter]), factors_.step, factors_.inv_scale);
}

void AdamW::take(int parameter, const torch::Tensor& gradient)
{
    torch::Tensor& values = parameters_[parameter];
    if (values.device().is_cpu()) {
        const torch::Tensor contiguous = gradient.contiguous();
        take(parameter, 0, values.numel(), contiguous.data_ptr<float>());
        return;
    }
    const torch::NoGradGuard no_grad;
    torch::Tensor &first = first_moments[parameter], &second = second_moments[parameter];
    first.mul_(beta_1).add_(gradient, 1 - beta_1);
    second.mul_(beta_2).addcmul_(gradient, gradient, 1 - beta_2);
    values.mul_(decay_of(values)).addcdiv_(first, second.sqrt().mul_(factors_.inv_scale).add_(epsilon), -factors_.step);
    if (copies_[parameter].defined()) copies_[parameter].copy_(values);
}

}  // namespace ndg
