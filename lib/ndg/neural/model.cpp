// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/model.h"

#include "ndg/core/error.h"
#include "ndg/neural/model_state.h"

#include <torch/utils.h>

#include <algorithm>

namespace ndg {
namespace {

/// Samples that go through the network together: enough to use the weights well, few enough to fit the memory.
constexpr std::size_t prediction_batch = 32;

}  // namespace

NdgModel::NdgModel(const NetworkOptions& options, const ShapeSpace& shape_space, const Template& body_template,
                   const std::string& template_sha256, std::uint64_t seed, Device device)
    : state_(std::make_unique<State>())
{
    options.check();
    require_input(shape_space.mean.size() == 3 * body_template.num_volume_vertices(),
                  "the shape space has {} coordinates where the template's volume has {}", shape_space.mean.size(),
                  3 * body_template.num_volume_vertices());
    State& state = *state_;
    state.options = options;
    state.shape_space = shape_space;
    state.skeleton = body_template.skeleton;
    state.prism_weights = body_template.prism_weights();
    state.visible = visible_joints(body_template);
    state.template_sha256 = template_sha256;
    state.num_prisms = body_template.num_prisms();
    state.seed = seed;
    state.device = device;
    // Until training fits the basis, all of its (zero) coefficients mean the identity.
    const RowMatrixF basis = RowMatrixF::Zero(options.output_basis, 9 * static_cast<Eigen::Index>(state.num_prisms));
    state.network = make_network(options, state.num_inputs(), state.num_prisms, basis, seed);
    state.network.to(device);
}

NdgModel::NdgModel(std::unique_ptr<State> state) : state_(std::move(state)) {}
NdgModel::~NdgModel() = default;
NdgModel::NdgModel(NdgModel&&) noexcept = default;
NdgModel& NdgModel::operator=(NdgModel&&) noexcept = default;

const NetworkOptions& NdgModel::options() const
{
    return state_->options;
}
const ShapeSpace& NdgModel::shape_space() const
{
    return state_->shape_space;
}
const TrainingCurve& NdgModel::curve() const
{
    return state_->curve;
}
const std::string& NdgModel::template_sha256() const
{
    return state_->template_sha256;
}
int NdgModel::num_prisms() const
{
    return state_->num_prisms;
}

std::int64_t NdgModel::num_parameters() const
{
    std::int64_t count = 0;
    for (const torch::Tensor& parameter : state_->network.parameters()) count += parameter.numel();
    return count;
}

Eigen::VectorXd NdgModel::encode(const Body& body) const
{
    return state_->shape_space.encode(body.volume_vertices);
}

std::vector<GradientsF> NdgModel::predict_residuals(const std::vector<PoseInput>& inputs) const
{
    const State& state = *state_;
    const torch::NoGradGuard no_grad;
    std::vector<GradientsF> predictions;
    predictions.reserve(inputs.size());
    for (std::size_t begin = 0; begin < inputs.size(); begin += prediction_batch) {
        const std::size_t count = std::min(prediction_batch, inputs.size() - begin);
        RowMatrixF features(static_cast<Eigen::Index>(count), state.num_inputs());
        for (std::size_t i = 0; i < count; ++i)
            features.row(static_cast<Eigen::Index>(i)) =
                network_features(inputs[begin + i], state.visible, state.shape_space, state.options.shape);
        const torch::Tensor outputs = state.network.forward(tensor_from(features).to(torch_device(state.device)), 0.0)
                                          .to(torch::kCPU)
                                          .contiguous();
        const float* data = outputs.data_ptr<float>();
        for (std::size_t i = 0; i < count; ++i, data += 9 * static_cast<std::ptrdiff_t>(state.num_prisms))
            predictions.emplace_back(Eigen::Map<const GradientsF>(data, state.num_prisms, 9));
    }
    return predictions;
}

std::vector<GradientsF> NdgModel::predict_gradients(const std::vector<PoseInput>& inputs) const
{
    const State& state = *state_;
    std::vector<GradientsF> predictions = predict_residuals(inputs);
    for (std::size_t i = 0; i < inputs.size(); ++i)
        rotate_residuals_in_place(predictions[i].data(), reference_rotations(state.skeleton, state.prism_weights,
                                                                             inputs[i].pose, state.options.rotation));
    return predictions;
}

}  // namespace ndg
