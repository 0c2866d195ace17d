// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/rest_pose.h"

#include "ndg/core/error.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>

namespace ndg {
namespace {

/// Vertices this far from the joint matter e times less, as a share of the nearest one's distance.
constexpr double ring_width = 0.6;
constexpr int min_ring_vertices = 6;

}  // namespace

Points unpose(const Eigen::Ref<const Points>& posed_vertices, const SkinningWeights& weights,
              const std::vector<Eigen::Isometry3d>& world_from_rest)
{
    Points rest(posed_vertices.rows(), 3);
    for (Eigen::Index v = 0; v < rest.rows(); ++v) {
        Eigen::Matrix3d linear = Eigen::Matrix3d::Zero();
        Eigen::Vector3d translation = Eigen::Vector3d::Zero();
        for (int k = 0; k < max_influences; ++k) {
            const Eigen::Isometry3d& motion = world_from_rest[static_cast<std::size_t>(weights.joints(v, k))];
            linear += weights.weights(v, k) * motion.linear();
            translation += weights.weights(v, k) * motion.translation();
        }
        require(linear.determinant() > 1e-3, "the fitted pose folds the skin at vertex {}", v);
        rest.row(v) = (linear.inverse() * (posed_vertices.row(v).transpose() - translation)).transpose();
    }
    return rest;
}

JointRegressor::JointRegressor(const Eigen::Ref<const Points>& skin_vertices, const SkinningWeights& weights,
                               const Eigen::Ref<const Points>& joint_positions)
    : template_skin_(skin_vertices), template_joints_(joint_positions)
{
    // Vertices near the joint, nearer ones more, of those that the joint or its parent moves.
    const auto& parents = standard_skeleton().parents;
    for (Eigen::Index j = 0; j < joint_positions.rows(); ++j) {
        const int parent = parents[static_cast<std::size_t>(j)];
        std::vector<std::pair<int, double>> ring;
        double nearest = std::numeric_limits<double>::infinity();
        for (Eigen::Index v = 0; v < skin_vertices.rows(); ++v) {
            double share = 0.0;
            for (int k = 0; k < max_influences; ++k) {
                if (weights.joints(v, k) == j || weights.joints(v, k) == parent) share += weights.weights(v, k);
            }
            if (share < 0.05) continue;
            const double distance = (skin_vertices.row(v) - joint_positions.row(j)).norm();
            nearest = std::min(nearest, distance);
            ring.emplace_back(static_cast<int>(v), distance);
        }
        if (static_cast<int>(ring.size()) < min_ring_vertices) {
            ring.clear();
            for (Eigen::Index v = 0; v < skin_vertices.rows(); ++v) {
                ring.emplace_back(static_cast<int>(v), (skin_vertices.row(v) - joint_positions.row(j)).norm());
                nearest = std::min(nearest, ring.back().second);
            }
        }
        nearest = std::max(nearest, 0.005);
        double sum = 0.0;
        for (auto& [vertex, value] : ring) {
            value = std::exp(-(value - nearest) / (ring_width * nearest));
            sum += value;
        }
        ring.erase(std::remove_if(ring.begin(), ring.end(), [](const auto& entry) { return entry.second < 1e-4; }),
                   ring.end());
        sum = 0.0;
        for (const auto& entry : ring) sum += entry.second;
        for (auto& entry : ring) entry.second /= sum;
        rings_.push_back(std::move(ring));
    }
}

Points JointRegressor::joints(const Eigen::Ref<const Points>& skin_vertices) const
{
    Points result(template_joints_.rows(), 3);
    for (Eigen::Index j = 0; j < result.rows(); ++j) {
        const auto& ring = rings_[static_cast<std::size_t>(j)];
        Eigen::RowVector3d from = Eigen::RowVector3d::Zero(), to = Eigen::RowVector3d::Zero();
        for (const auto& [vertex, weight] : ring) {
            from += weight * template_skin_.row(vertex);
            to += weight * skin_vertices.row(vertex);
        }
        // Scales along the axes from the spread of the ring: the pose is the template's, so its axes are the body's.
        Eigen::RowVector3d before = Eigen::RowVector3d::Zero(), after = Eigen::RowVector3d::Zero();
        for (const auto& [vertex, weight] : ring) {
            before += weight * (template_skin_.row(vertex) - from).cwiseAbs2();
            after += weight * (template_skin_.row(vertex) - from).cwiseProduct(skin_vertices.row(vertex) - to);
        }
        const Eigen::RowVector3d scale = after.cwiseQuotient(before.cwiseMax(1e-12));
        result.row(j) = to + scale.cwiseProduct(template_joints_.row(j) - from);
    }
    return result;
}

}  // namespace ndg
