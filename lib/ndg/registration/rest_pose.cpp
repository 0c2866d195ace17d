// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/rest_pose.h"

#include "ndg/core/error.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>

namespace ndg {
namespace {

/// A joint is a combination of the nearest vertices in that many directions, each looked for in a cone of this angle.
constexpr int num_directions = 100;
const double min_direction_cosine = std::cos(25.0 * EIGEN_PI / 180.0);
constexpr std::size_t min_ring_vertices = 20;
/// Weight of small coefficients against errors at the joint, m^2: coefficients of norm one answer to errors of the skin
/// as large as the fit's own, some mm.
constexpr double ridge = 3e-5;
/// The template itself counts as much as this many examples: its joints are reproduced.
constexpr double template_weight = 100.0;

/// Vertices all around a joint that it or its parent moves.
std::vector<int> ring_of(const Eigen::Ref<const Points>& skin, const SkinningWeights& weights,
                         const Eigen::RowVector3d& position, int joint, int parent)
{
    std::vector<int> ring;
    for (const double least_share : {0.05, 0.0}) {
        std::vector<int> rows;
        for (Eigen::Index v = 0; v < skin.rows(); ++v) {
            double share = 0.0;
            for (int k = 0; k < max_influences; ++k) {
                if (weights.joints(v, k) == joint || weights.joints(v, k) == parent) share += weights.weights(v, k);
            }
            if (share >= least_share) rows.push_back(static_cast<int>(v));
        }
        ring.clear();
        for (int d = 0; d < num_directions; ++d) {
            // Fibonacci's lattice on the sphere.
            const double height = 1.0 - (2.0 * d + 1.0) / num_directions, radius = std::sqrt(1.0 - height * height);
            const double angle = d * EIGEN_PI * (3.0 - std::sqrt(5.0));
            const Eigen::RowVector3d direction(radius * std::cos(angle), height, radius * std::sin(angle));
            int best = -1;
            double least = 0.0;
            for (const int v : rows) {
                const Eigen::RowVector3d offset = skin.row(v) - position;
                const double distance = offset.norm();
                if (offset.dot(direction) < min_direction_cosine * distance || (best >= 0 && distance >= least))
                    continue;
                best = v;
                least = distance;
            }
            if (best >= 0) ring.push_back(best);
        }
        std::sort(ring.begin(), ring.end());
        ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
        // Joints that move no skin of their own take the skin next to them.
        if (ring.size() >= min_ring_vertices) break;
    }
    return ring;
}

}  // namespace

Points unpose(const Eigen::Ref<const Points>& posed_vertices, const SkinningWeights& weights,
              const std::vector<Eigen::Isometry3d>& world_from_rest)
{
    Points rest(posed_vertices.rows(), 3);
    for (Eigen::Index v = 0; v < rest.rows(); ++v) {
        Eigen::Matrix3d linear = Eigen::Matrix3d::Zero();
        Eigen::Vector3d translation = Eigen::Vector3d::Zero();
        for (int k = 0; k < max_influences; ++k) {
            const Eigen::Isometry3d& motion = world_from_rest[weights.joints(v, k)];
            linear += weights.weights(v, k) * motion.linear();
            translation += weights.weights(v, k) * motion.translation();
        }
        require(linear.determinant() > 1e-3, "the fitted pose folds the skin at vertex {}", v);
        rest.row(v) = (linear.inverse() * (posed_vertices.row(v).transpose() - translation)).transpose();
    }
    return rest;
}

JointRegressor::JointRegressor(const Eigen::Ref<const Points>& skin_vertices, const SkinningWeights& weights,
                               const Eigen::Ref<const Points>& joint_positions,
                               const std::vector<JointExample>& examples)
{
    const auto& parents = standard_skeleton().parents;
    for (Eigen::Index j = 0; j < joint_positions.rows(); ++j) {
        const std::vector<int> ring =
            ring_of(skin_vertices, weights, joint_positions.row(j), static_cast<int>(j), parents[j]);
        // Relative to the first vertex of the ring, coefficients sum to one by themselves.
        const auto count = static_cast<Eigen::Index>(ring.size()) - 1;
        const auto rows_of = [&](const Eigen::Ref<const Points>& skin, const Eigen::RowVector3d& joint,
                                 Eigen::MatrixXd& edges, Eigen::VectorXd& offset) {
            edges.resize(3, count);
            for (Eigen::Index i = 0; i < count; ++i) {
                edges.col(i) = (skin.row(ring[static_cast<std::size_t>(i) + 1]) - skin.row(ring[0])).transpose();
            }
            offset = (joint - skin.row(ring[0])).transpose();
        };
        Eigen::MatrixXd edges, normal = Eigen::MatrixXd::Zero(count, count);
        Eigen::VectorXd offset, right = Eigen::VectorXd::Zero(count);
        rows_of(skin_vertices, joint_positions.row(j), edges, offset);
        const double examples_weight = static_cast<double>(std::max<std::size_t>(examples.size(), 1));
        // Near vertices say more of a joint than far ones.
        Eigen::VectorXd prior(count);
        double first = 0.0;
        for (Eigen::Index i = 0; i <= count; ++i) {
            const double closeness = 1.0 / (skin_vertices.row(ring[i]) - joint_positions.row(j)).squaredNorm();
            (i == 0 ? first : prior[i - 1]) = closeness;
        }
        prior /= first + prior.sum();
        normal += template_weight * edges.transpose() * edges;
        right += template_weight * edges.transpose() * (offset - edges * prior);
        for (const JointExample& example : examples) {
            rows_of(example.skin_vertices, example.joint_positions.row(j), edges, offset);
            normal += edges.transpose() * edges;
            right += edges.transpose() * (offset - edges * prior);
        }
        normal.diagonal().array() += ridge * examples_weight;
        const Eigen::VectorXd coefficients = prior + normal.ldlt().solve(right);
        std::vector<std::pair<int, double>> combination = {{ring[0], 1.0 - coefficients.sum()}};
        for (Eigen::Index i = 0; i < count; ++i) {
            combination.emplace_back(ring[static_cast<std::size_t>(i) + 1], coefficients[i]);
        }
        combinations_.push_back(std::move(combination));
    }
}

Points JointRegressor::joints(const Eigen::Ref<const Points>& skin_vertices) const
{
    Points result = Points::Zero(static_cast<Eigen::Index>(combinations_.size()), 3);
    for (Eigen::Index j = 0; j < result.rows(); ++j) {
        for (const auto& [vertex, coefficient] : combinations_[j]) {
            result.row(j) += coefficient * skin_vertices.row(vertex);
        }
    }
    return result;
}

}  // namespace ndg
