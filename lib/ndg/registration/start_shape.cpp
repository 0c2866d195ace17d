// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/start_shape.h"

#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

namespace ndg {
namespace {

constexpr int max_rows = 1500;
constexpr std::size_t num_averaged = 3;

double stature(const Eigen::Ref<const Points>& skin)
{
    return skin.col(1).maxCoeff() - skin.col(1).minCoeff();
}

/// Joints between which the bone of each joint of trunk and limbs lies; -1 for the others.
std::vector<std::pair<int, int>> bones()
{
    const Skeleton& skeleton = standard_skeleton();
    std::vector<std::pair<int, int>> result(skeleton.num_joints(), {-1, -1});
    const auto set = [&](const std::string& joint, const std::string& begin, const std::string& end) {
        result[skeleton.joint(joint)] = {skeleton.joint(begin), skeleton.joint(end)};
    };
    for (const char* joint : {"pelvis", "spine_1", "spine_2", "spine_3", "spine_4", "spine_5"}) {
        set(joint, "pelvis", "neck_1");
    }
    for (const std::string side : {"left_", "right_"}) {
        const std::array<std::array<const char*, 3>, 5> limbs = {{{"upper_arm", "upper_arm", "forearm"},
                                                                  {"forearm", "forearm", "hand"},
                                                                  {"forearm_twist", "forearm", "hand"},
                                                                  {"thigh", "thigh", "shin"},
                                                                  {"shin", "shin", "foot"}}};
        for (const auto& [joint, begin, end] : limbs) set(side + joint, side + begin, side + end);
    }
    return result;
}

}  // namespace

StartShapes::StartShapes(const SkinnedSurface& skin, const JointRegressor& regressor,
                         std::vector<JointExample> examples)
    : skin_(skin), regressor_(regressor), examples_(std::move(examples))
{
    if (examples_.empty()) return;
    const auto joint_bones = bones();
    const Eigen::VectorXd areas = vertex_areas(skin.vertices, skin.triangles);
    const Eigen::Index step = std::max<Eigen::Index>(1, skin.vertices.rows() / max_rows);
    std::vector<double> root_areas;
    for (Eigen::Index v = 0; v < skin.vertices.rows(); v += step) {
        Eigen::Index slot = 0;
        skin.weights.weights.row(v).maxCoeff(&slot);
        const auto [begin, end] = joint_bones[skin.weights.joints(v, slot)];
        if (begin < 0) continue;
        rows_.push_back(static_cast<int>(v));
        begin_.push_back(begin);
        end_.push_back(end);
        root_areas.push_back(std::sqrt(areas[v]));
    }
    root_areas_ = Eigen::Map<const Eigen::VectorXd>(root_areas.data(), static_cast<Eigen::Index>(root_areas.size()));
    for (const JointExample& example : examples_) profiles_.push_back(profile(example.skin_vertices));
}

Eigen::VectorXd StartShapes::profile(const Eigen::Ref<const Points>& rest_skin) const
{
    // Joints by the regressor, of examples too: they are compared with joints found that way.
    const Points joints = regressor_.joints(rest_skin);
    Eigen::VectorXd distances(root_areas_.size());
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        const Eigen::RowVector3d bone = (joints.row(end_[i]) - joints.row(begin_[i])).normalized();
        const Eigen::RowVector3d offset = rest_skin.row(rows_[i]) - joints.row(begin_[i]);
        distances[static_cast<Eigen::Index>(i)] = offset.cross(bone).norm();
    }
    return distances.cwiseProduct(root_areas_) / stature(rest_skin);
}

SkinnedSurface StartShapes::nearest(const Eigen::Ref<const Points>& rest_skin) const
{
    const Eigen::VectorXd wanted = profile(rest_skin);
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t e = 0; e < examples_.size(); ++e) {
        order.emplace_back((profiles_[e] - wanted).squaredNorm(), e);
    }
    std::sort(order.begin(), order.end());
    order.resize(std::min(order.size(), num_averaged));
    SkinnedSurface result = skin_;
    result.vertices.setZero();
    result.joint_positions.setZero();
    double sum = 0.0;
    const double height = stature(rest_skin);
    for (const auto& [squared_distance, e] : order) {
        const double weight = 1.0 / std::max(squared_distance, 1e-12);
        const double scale = weight * height / stature(examples_[e].skin_vertices);
        result.vertices += scale * examples_[e].skin_vertices;
        result.joint_positions += scale * examples_[e].joint_positions;
        sum += weight;
    }
    result.vertices /= sum;
    result.joint_positions /= sum;
    return result;
}

}  // namespace ndg
