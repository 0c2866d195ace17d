// SPDX-License-Identifier: Apache-2.0
// Internal to this module (includes libtorch): AdamW (Loshchilov and Hutter 2019).
#pragma once

#include <torch/types.h>

#include <cstdint>
#include <vector>

namespace ndg {

/// Takes gradients as a backward pass makes them (TrainingPass), each entry once a step.
class GradientSink {
public:
    virtual ~GradientSink() = default;
    /// Of `count` entries of a parameter (by its place in TorchNetwork::parameters) on the CPU, from entry `first` on.
    /// Several threads bring disjoint entries at once.
    virtual void take(int parameter, std::int64_t first, std::int64_t count, const float* gradient) = 0;
    /// Of a whole parameter, on any device.
    virtual void take(int parameter, const torch::Tensor& gradient) = 0;
};

/// The update of torch::optim::AdamW (beta 0.9 and 0.999, epsilon 1e-8), with its whole state in plain tensors. Weight
/// decay acts on matrices only. On the CPU gradients are used while they lie in the cache: a matrix's are never all
/// in memory, and parameter, moments and the copy for products pass through it once a step.
class AdamW : public GradientSink {
public:
    /// `copies`: for each parameter what products read in its place, kept equal to it but for rounding; undefined where
    /// they read the parameter. Empty: no copies.
    AdamW(std::vector<torch::Tensor> parameters, std::vector<torch::Tensor> copies, double weight_decay);

    /// The gradients that come now are those of the next step.
    void begin_step(double learning_rate);
    void take(int parameter, std::int64_t first, std::int64_t count, const float* gradient) override;
    void take(int parameter, const torch::Tensor& gradient) override;

    std::int64_t num_steps = 0;
    std::vector<torch::Tensor> first_moments, second_moments;

private:
    /// What is the same for all entries of a step.
    struct StepFactors {
        float rate = 0;       ///< learning rate
        float step = 0;       ///< learning rate over the first moment's bias correction
        float inv_scale = 0;  ///< one over the square root of the second moment's bias correction
    };
    float decay_of(const torch::Tensor& parameter) const;

    std::vector<torch::Tensor> parameters_, copies_;
    double weight_decay_;
    StepFactors factors_;
};

}  // namespace ndg
