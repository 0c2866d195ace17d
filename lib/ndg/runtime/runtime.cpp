// SPDX-License-Identifier: Apache-2.0
#include "ndg/runtime/runtime.h"

#include "ndg/body/anatomy.h"
#include "ndg/bones/rigid_wrap.h"
#include "ndg/core/error.h"

#include <chrono>
#include <exception>

namespace ndg {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_between(Clock::time_point begin, Clock::time_point end)
{
    return std::chrono::duration<double>(end - begin).count();
}

const RuntimeModel& require_fitting(const Template& body_template, const RuntimeModel& model)
{
    require_input(model.template_sha256 == body_template.file_sha256,
                  "{}: the model was trained on another template ({}..., not {}...)", model.path(),
                  model.template_sha256.substr(0, 12), body_template.file_sha256.substr(0, 12));
    require_input(model.joint_names == body_template.skeleton.joint_names,
                  "{}: the joints of the model are not those of the template", model.path());
    require_input(model.num_prisms() == body_template.num_prisms(), "{}: gives {} prisms where the template has {}",
                  model.path(), model.num_prisms(), body_template.num_prisms());
    return model;
}

std::vector<int> rows_beyond_volume(const Template& body_template)
{
    std::vector<char> in_volume(static_cast<std::size_t>(body_template.skin_weights.size()), 0);
    for (const int v : body_template.wrap_to_skin) in_volume[v] = 1;
    std::vector<int> rows;
    for (int v = 0; v < static_cast<int>(in_volume.size()); ++v)
        if (in_volume[v] == 0) rows.push_back(v);
    return rows;
}

}  // namespace

Runtime::Runtime(const Template& body_template, const RuntimeModel& model)
    : template_(body_template),
      model_(require_fitting(body_template, model)),
      input_space_(body_template, model.shape_space, model.traits.shape),
      bones_(model.traits.posing.bone_wrap == BoneWrap::rigid ? std::make_unique<const RiggedBodies>(body_template)
                                                              : nullptr),
      wrap_weights_(select_weights(body_template.skin_weights, body_template.wrap_to_skin)),
      network_(model),
      forces_(body_template, network_.prisms(), model.traits),
      skin_beyond_volume_(rows_beyond_volume(body_template), body_template.skin_weights),
      carried_anatomy_(body_template, bones_.get()),
      volume_(PointColumns::Zero(4, body_template.num_volume_vertices() + body_template.rest.interior_vertices.rows())),
      volume_points_(PointsF::Zero(body_template.num_volume_vertices(), 3)),
      skin_(PointsF::Zero(body_template.skin_weights.size(), 3)),
      anatomy_(PointsF::Zero(body_template.anatomy_vertices.rows(), 3))
{
    require_input(model.visible_joints == input_space_.visible_joints(),
                  "{}: the joints that the network sees do not fit the template's skinning weights", model.path());
}

void Runtime::set_body(const Body& body)
{
    require_input(body.volume_vertices.rows() == template_.num_volume_vertices() &&
                      body.joint_positions.rows() == template_.skeleton.num_joints() &&
                      body.skin_vertices.rows() == template_.skin_weights.size(),
                  "body {} does not belong to the template", body.name);
    body_ = nullptr;
    const RestOperators rest(template_.prisms, body.volume_vertices);
    const PoissonMatrices matrices(rest, template_.num_wrap_vertices());
    if (!analyzed_) solver_.analyze(matrices.free);
    analyzed_ = true;
    solver_.factorize(matrices.free);
    forces_.set_rest(rest, matrices);
    skin_beyond_volume_.set_rest(body.skin_vertices);
    carried_anatomy_.set_rest(anatomy_at_rest(template_, body));
    if (bones_) rig_ = bones_->of(body);
    shape_code_ = input_space_.encode(body);
    body_ = &body;
}

/// Columns of the bone wrap and of what lies inside it.
void Runtime::pose_bone_wrap()
{
    const Clock::time_point begin = Clock::now();
    const int num_wrap = template_.num_wrap_vertices(), num_volume = template_.num_volume_vertices();
    const auto rest_wrap = body_->volume_vertices.topRows(num_wrap);
    Points interior;
    if (bones_) {
        const RigidWrap wrap = pose_rigid_wrap(bones_->rig(), *rig_, rest_wrap, world_from_rest_);
        carried_anatomy_.set_motions(wrap.segments);
        volume_.topLeftCorner(3, num_wrap) = wrap.vertices.transpose().cast<float>();
        interior = dual_quaternion_blending(body_->interior_vertices, bones_->rig().interior_weights, wrap.segments);
    } else {
        volume_.topLeftCorner(3, num_wrap) =
            linear_blend_skinning(rest_wrap, wrap_weights_, world_from_rest_).transpose().cast<float>();
        interior = linear_blend_skinning(body_->interior_vertices, template_.interior_weights, world_from_rest_);
    }
    volume_.block(0, num_volume, 3, interior.rows()) = interior.transpose().cast<float>();
    seconds_.bone_wrap = seconds_between(begin, Clock::now());
}

void Runtime::set_pose(const Pose& pose)
{
    require_input(body_ != nullptr, "a body must be set before a pose");
    const Clock::time_point begin = Clock::now();
    const Eigen::RowVectorXf features = input_space_.features({shape_code_, pose});
    world_from_rest_ = forward_kinematics(template_.skeleton, body_->joint_positions, pose);
    std::vector<Eigen::Matrix<float, 3, 4>> motions(world_from_rest_.size());
    for (std::size_t j = 0; j < motions.size(); ++j)
        motions[j] = world_from_rest_[j].matrix().topRows<3>().cast<float>();
    const Clock::time_point posed = Clock::now();

    std::exception_ptr failure;
#pragma omp parallel
    {
        network_.hidden(features);
#pragma omp single nowait
        {
            try {
                pose_bone_wrap();
            } catch (...) {
                failure = std::current_exception();
            }
        }
        network_.last();
    }
    if (failure) std::rethrow_exception(failure);
    const Clock::time_point predicted = Clock::now();

#pragma omp parallel
    forces_.right_hand_side(network_.outputs(), world_from_rest_, volume_);
    const Clock::time_point summed = Clock::now();

    const int num_wrap = template_.num_wrap_vertices(), num_volume = template_.num_volume_vertices();
    solver_.solve(volume_.middleCols(num_wrap, num_volume - num_wrap));
    const Clock::time_point solved = Clock::now();

#pragma omp parallel
    {
#pragma omp for schedule(static) nowait
        for (int v = 0; v < num_volume; ++v) volume_points_.row(v) = volume_.col(v).head<3>().transpose();
#pragma omp for schedule(static) nowait
        for (int v = 0; v < num_wrap; ++v)
            skin_.row(template_.wrap_to_skin[v]) = volume_.col(2 * num_wrap + v).head<3>().transpose();
        skin_beyond_volume_.pose(motions, skin_);
        carried_anatomy_.pose(volume_, motions, anatomy_);
    }
    const Clock::time_point end = Clock::now();
    seconds_.pose = seconds_between(begin, posed);
    seconds_.network = seconds_between(posed, predicted);
    seconds_.prisms = seconds_between(predicted, summed);
    seconds_.solve = seconds_between(summed, solved);
    seconds_.carried = seconds_between(solved, end);
}

}  // namespace ndg
