// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/skeleton.h"
#include "ndg/core/types.h"

#include <vector>

namespace ndg {

constexpr int max_influences = 8;

/// Sparse skinning weights, at most 8 a row; unused slots hold joint 0 with weight 0; rows sum to one.
struct SkinningWeights {
    Eigen::Matrix<int, Eigen::Dynamic, max_influences, Eigen::RowMajor> joints;
    Eigen::Matrix<double, Eigen::Dynamic, max_influences, Eigen::RowMajor> weights;

    Eigen::Index size() const { return joints.rows(); }
};

/// The `max_influences` largest entries of each row of a dense N x J matrix, normalised to sum one.
/// Throws Error for a row without positive weight.
SkinningWeights sparsify_weights(const Eigen::Ref<const RowMatrix>& dense);
/// The same weights as a dense N x J matrix.
RowMatrix dense_weights(const SkinningWeights& weights, int num_joints);
/// Row i is the row `rows[i]` of `weights`.
SkinningWeights select_weights(const SkinningWeights& weights, const std::vector<int>& rows);
/// One row an element: mean of its vertices' weights, the 8 largest kept. `elements`: N x k vertex indices.
SkinningWeights element_weights(const SkinningWeights& vertex_weights, const Eigen::Ref<const RowMatrixI>& elements,
                                int num_joints);

/// Linear blend skinning (Magnenat-Thalmann 1988). N x 3 in, N x 3 out.
Points linear_blend_skinning(const Eigen::Ref<const Points>& rest_vertices, const SkinningWeights& weights,
                             const std::vector<Eigen::Isometry3d>& world_from_rest);

/// R_p: normalised blend of bone quaternions, antipodal signs aligned to the largest weight (NDG equation 11).
std::vector<Eigen::Matrix3d> blend_rotations(const SkinningWeights& weights,
                                             const std::vector<Eigen::Isometry3d>& world_from_rest);

}  // namespace ndg
