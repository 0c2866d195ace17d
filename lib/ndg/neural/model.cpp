// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/model.h"

#include "ndg/core/error.h"
#include "ndg/core/threads.h"
#include "ndg/neural/model_state.h"

#include <torch/utils.h>

#include <algorithm>

namespace ndg {
namespace {

/// Samples that go through the network together: enough to use the weights well, few enough to fit the memory.
constexpr int prediction_batch = 32;

}  // namespace

NeuralModel::NeuralModel(const NetworkOptions& options, const ShapeSpace& shape_space, const Template& body_template,
                         std::shared_ptr<const OutputSpace> output_space, std::uint64_t seed, Device device)
{
    options.check();
    // Before libtorch does anything: otherwise it sets the number of OpenMP threads itself, in Debian's build to one.
    torch::set_num_threads(std::max(1, num_threads()));
    require_input(options.output_basis == 0 || output_space->has_approximate_inverse(),
                  "output_basis {} needs predictions that can be taken back to outputs of the network",
                  options.output_basis);
    state_ = std::make_unique<State>(State{options,
                                           InputSpace(body_template, shape_space, options.shape),
                                           std::move(output_space),
                                           body_template.file_sha256,
                                           seed,
                                           device,
                                           {},
                                           {},
                                           {},
                                           {}});
    if (options.region_reach > 0)
        state_->columns =
            regional_columns(body_template, state_->input_space, *state_->output_space, options.region_reach);
    // Until training fits the bases, all of their (zero) coefficients mean the neutral prediction.
    std::vector<RowMatrixF> bases;
    if (options.output_basis > 0 && state_->columns.empty())
        bases.push_back(RowMatrixF::Zero(options.output_basis, state_->output_space->width()));
    else if (options.output_basis > 0)
        for (const NetworkColumns& columns : state_->columns)
            bases.push_back(RowMatrixF::Zero(options.output_basis, static_cast<Eigen::Index>(columns.outputs.size())));
    state_->network = state_->new_network(bases);
    state_->network.to(device);
}

NeuralModel::NeuralModel(const NetworkOptions& options, const ShapeSpace& shape_space, const Template& body_template,
                         std::uint64_t seed, Device device)
    : NeuralModel(options, shape_space, body_template, make_output_space(body_template, options), seed, device)
{
}

NeuralModel::~NeuralModel() = default;
NeuralModel::NeuralModel(NeuralModel&&) noexcept = default;
NeuralModel& NeuralModel::operator=(NeuralModel&&) noexcept = default;

const NetworkOptions& NeuralModel::options() const
{
    return state_->options;
}
const InputSpace& NeuralModel::input_space() const
{
    return state_->input_space;
}
const OutputSpace& NeuralModel::output_space() const
{
    return *state_->output_space;
}
const TrainingCurve& NeuralModel::curve() const
{
    return state_->curve;
}

std::int64_t NeuralModel::num_parameters() const
{
    std::int64_t count = 0;
    for (const torch::Tensor& parameter : state_->network.parameters()) count += parameter.numel();
    return count;
}

RowMatrixF NeuralModel::predict(const std::vector<PoseInput>& inputs) const
{
    const torch::NoGradGuard no_grad;
    const int num_samples = static_cast<int>(inputs.size());
    RowMatrixF predictions(num_samples, state_->output_space->width());
    for (int begin = 0; begin < num_samples; begin += prediction_batch) {
        const int count = std::min(prediction_batch, num_samples - begin);
        RowMatrixF features(count, state_->input_space.width());
        for (int i = 0; i < count; ++i) features.row(i) = state_->input_space.features(inputs[begin + i]);
        const torch::Tensor rows = state_->predict(features).to(torch::kCPU).contiguous();
        predictions.middleRows(begin, count) =
            Eigen::Map<const RowMatrixF>(rows.data_ptr<float>(), count, predictions.cols());
    }
    return predictions;
}

}  // namespace ndg
