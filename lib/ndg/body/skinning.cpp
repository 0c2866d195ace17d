// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/skinning.h"

#include "ndg/core/error.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ndg {

namespace {

/// Writes the largest of `influences` (joint, weight > 0), normalised to sum one, into row `row`. Order: by falling
/// weight, equal weights by joint, so that the same influences always give the same row.
void set_row(SkinningWeights& result, Eigen::Index row, std::vector<std::pair<int, double>>& influences)
{
    const std::size_t kept = std::min<std::size_t>(influences.size(), max_influences);
    std::partial_sort(
        influences.begin(), influences.begin() + static_cast<std::ptrdiff_t>(kept), influences.end(),
        [](const auto& a, const auto& b) { return a.second != b.second ? a.second > b.second : a.first < b.first; });
    double sum = 0.0;
    for (std::size_t i = 0; i < kept; ++i) sum += influences[i].second;
    require(sum > 0.0 && std::isfinite(sum), "Row {} of the skinning weights has no positive, finite weight", row);
    for (std::size_t i = 0; i < kept; ++i) {
        const auto slot = static_cast<Eigen::Index>(i);
        result.joints(row, slot) = influences[i].first;
        result.weights(row, slot) = influences[i].second / sum;
    }
}

SkinningWeights empty_weights(Eigen::Index rows)
{
    SkinningWeights weights;
    weights.joints.setZero(rows, max_influences);
    weights.weights.setZero(rows, max_influences);
    return weights;
}

void check_joints(const SkinningWeights& weights, std::size_t num_joints)
{
    if (weights.size() == 0) return;
    require(weights.joints.minCoeff() >= 0 && weights.joints.maxCoeff() < static_cast<int>(num_joints),
            "Skinning weights refer to joints {}..{}, but there are {} joints", weights.joints.minCoeff(),
            weights.joints.maxCoeff(), num_joints);
}

}  // namespace

SkinningWeights sparsify_weights(const Eigen::Ref<const RowMatrix>& dense)
{
    SkinningWeights result = empty_weights(dense.rows());
    std::vector<std::pair<int, double>> influences;
    for (Eigen::Index i = 0; i < dense.rows(); ++i) {
        influences.clear();
        for (Eigen::Index j = 0; j < dense.cols(); ++j) {
            require(std::isfinite(dense(i, j)), "The skinning weight of row {} and joint {} is not finite", i, j);
            if (dense(i, j) > 0.0) influences.emplace_back(static_cast<int>(j), dense(i, j));
        }
        set_row(result, i, influences);
    }
    return result;
}

RowMatrix dense_weights(const SkinningWeights& weights, int num_joints)
{
    RowMatrix dense = RowMatrix::Zero(weights.size(), num_joints);
    for (Eigen::Index v = 0; v < dense.rows(); ++v)
        for (int k = 0; k < max_influences; ++k) dense(v, weights.joints(v, k)) += weights.weights(v, k);
    return dense;
}

SkinningWeights select_weights(const SkinningWeights& weights, const std::vector<int>& rows)
{
    SkinningWeights result = empty_weights(static_cast<Eigen::Index>(rows.size()));
    for (std::size_t i = 0; i < rows.size(); ++i) {
        require(rows[i] >= 0 && rows[i] < weights.size(), "Row {} was asked of {} rows of skinning weights", rows[i],
                weights.size());
        result.joints.row(static_cast<Eigen::Index>(i)) = weights.joints.row(rows[i]);
        result.weights.row(static_cast<Eigen::Index>(i)) = weights.weights.row(rows[i]);
    }
    return result;
}

SkinningWeights element_weights(const SkinningWeights& vertex_weights, const Eigen::Ref<const RowMatrixI>& elements,
                                int num_joints)
{
    check_joints(vertex_weights, static_cast<std::size_t>(num_joints));
    SkinningWeights result = empty_weights(elements.rows());
    std::vector<double> sums(num_joints, 0.0);
    std::vector<std::pair<int, double>> influences;
    for (Eigen::Index e = 0; e < elements.rows(); ++e) {
        influences.clear();
        for (Eigen::Index k = 0; k < elements.cols(); ++k) {
            const int vertex = elements(e, k);
            require(vertex >= 0 && vertex < vertex_weights.size(), "Element {} has vertex {} of {}", e, vertex,
                    vertex_weights.size());
            for (Eigen::Index slot = 0; slot < max_influences; ++slot) {
                const double weight = vertex_weights.weights(vertex, slot);
                if (weight <= 0.0) continue;
                const int joint = vertex_weights.joints(vertex, slot);
                double& sum = sums[joint];
                if (sum == 0.0) influences.emplace_back(joint, 0.0);
                sum += weight;
            }
        }
        for (auto& [joint, weight] : influences) {
            weight = std::exchange(sums[joint], 0.0);
        }
        set_row(result, e, influences);
    }
    return result;
}

Points linear_blend_skinning(const Eigen::Ref<const Points>& rest_vertices, const SkinningWeights& weights,
                             const std::vector<Eigen::Isometry3d>& world_from_rest)
{
    require(weights.size() == rest_vertices.rows(), "{} vertices were given {} rows of skinning weights",
            rest_vertices.rows(), weights.size());
    check_joints(weights, world_from_rest.size());
    Points posed(rest_vertices.rows(), 3);
#pragma omp parallel for schedule(static)
    for (Eigen::Index i = 0; i < rest_vertices.rows(); ++i) {
        const Eigen::Vector3d rest = rest_vertices.row(i).transpose();
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (Eigen::Index slot = 0; slot < max_influences; ++slot) {
            const double weight = weights.weights(i, slot);
            if (weight == 0.0) continue;
            const Eigen::Isometry3d& motion = world_from_rest[weights.joints(i, slot)];
            sum += weight * (motion.linear() * rest + motion.translation());
        }
        posed.row(i) = sum.transpose();
    }
    return posed;
}

std::vector<Eigen::Matrix3d> blend_rotations(const SkinningWeights& weights,
                                             const std::vector<Eigen::Isometry3d>& world_from_rest)
{
    check_joints(weights, world_from_rest.size());
    std::vector<Eigen::Vector4d> quaternions;
    quaternions.reserve(world_from_rest.size());
    for (const Eigen::Isometry3d& motion : world_from_rest) {
        quaternions.push_back(Eigen::Quaterniond(Eigen::Matrix3d(motion.linear())).normalized().coeffs());
    }

    std::vector<Eigen::Matrix3d> rotations(weights.size());
#pragma omp parallel for schedule(static)
    for (Eigen::Index i = 0; i < weights.size(); ++i) {
        Eigen::Index largest = 0;
        weights.weights.row(i).maxCoeff(&largest);
        const Eigen::Vector4d& reference = quaternions[weights.joints(i, largest)];
        Eigen::Vector4d sum = Eigen::Vector4d::Zero();
        for (Eigen::Index slot = 0; slot < max_influences; ++slot) {
            const double weight = weights.weights(i, slot);
            if (weight == 0.0) continue;
            const Eigen::Vector4d& quaternion = quaternions[weights.joints(i, slot)];
            // q and -q are the same rotation; the sum is at least the largest weight long once signs agree.
            sum += (quaternion.dot(reference) < 0.0 ? -weight : weight) * quaternion;
        }
        rotations[i] = Eigen::Quaterniond(Eigen::Vector4d(sum.normalized())).toRotationMatrix();
    }
    return rotations;
}

}  // namespace ndg
