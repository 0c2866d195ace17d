// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/objective.h"

#include "ndg/neural/coefficients.h"

#include <algorithm>

namespace ndg {
namespace {

using torch::Tensor;

class PredictionObjective : public Objective {
public:
    PredictionObjective(const TrainingSet& set, const Augmentation* augmentation, const OutputSpace& space,
                        Device device)
        : set_(set),
          augmentation_(augmentation),
          space_(space),
          neutral_(torch::tensor(neutral_prediction(space)).to(torch_device(device)))
    {
    }

    LastLayer last_layer() const override { return LastLayer::outputs; }
    int width() const override { return set_.width(); }
    void target(int sample_idx, const SampleChange& change, float* target) const override
    {
        if (augmentation_)
            augmentation_->target(sample_idx, change, target);
        else
            set_.target(sample_idx, target);
    }
    Tensor loss(const Tensor& outputs, const Tensor& targets) const override
    {
        return torch::mse_loss(space_.activate(outputs), targets);
    }
    double neutral_loss(const Tensor& targets) const override
    {
        return torch::mean((targets - neutral_).square(), torch::kFloat64).item<double>();
    }

private:
    const TrainingSet& set_;
    const Augmentation* augmentation_;
    const OutputSpace& space_;
    Tensor neutral_;
};

class CoefficientObjective : public Objective {
public:
    CoefficientObjective(Coefficients coefficients, int num_outputs, Device device)
        : coefficients_(std::move(coefficients)), remainder_(coefficients_.mean_remainder() / num_outputs)
    {
        const Eigen::RowVectorXf weights = (coefficients_.squared_norms() / num_outputs).cast<float>();
        weights_ = tensor_from(weights).to(torch_device(device));
    }

    LastLayer last_layer() const override { return LastLayer::coefficients; }
    int width() const override { return coefficients_.width(); }
    void target(int sample_idx, const SampleChange& change, float* target) const override
    {
        coefficients_.of_sample(sample_idx, change, target);
    }
    Tensor loss(const Tensor& outputs, const Tensor& targets) const override
    {
        return ((outputs - targets).square() * weights_).sum() / targets.size(0) + remainder_;
    }
    double neutral_loss(const Tensor& targets) const override
    {
        return loss(torch::zeros_like(targets), targets).item<double>();
    }

private:
    Coefficients coefficients_;
    double remainder_;  ///< a predicted number
    Tensor weights_;    ///< 1 x K, of squared differences
};

}  // namespace

std::unique_ptr<Objective> make_objective(const TrainingSet& set, const Augmentation* augmentation,
                                          const OutputSpace& output_space, const Network& network, Device device)
{
    const bool all_fixed = std::all_of(network.parts.begin(), network.parts.end(),
                                       [](const Network::Part& part) { return part.perceptron.basis.defined(); });
    if (all_fixed && output_space.adds_to_neutral())
        return std::make_unique<CoefficientObjective>(Coefficients(set, augmentation, output_space, network),
                                                      output_space.width(), device);
    return std::make_unique<PredictionObjective>(set, augmentation, output_space, device);
}

}  // namespace ndg
