// SPDX-License-Identifier: Apache-2.0
// Skinning weights with any number of joints a vertex: what interpolation carries into a volume is blended from many.
#pragma once

#include "ndg/body/skinning.h"
#include "ndg/core/types.h"

#include <Eigen/SparseCore>

#include <string>
#include <vector>

namespace ndg {

/// N x K, rows non-negative and summing to one, compressed.
using JointWeights = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// The entries of a dense N x K matrix that are not zero.
JointWeights sparse_weights(const Eigen::Ref<const RowMatrix>& dense);
JointWeights sparse_weights(const SkinningWeights& weights, int num_joints);

/// The blended motions of a vertex's joints, which linear blend skinning applies to it.
Eigen::Matrix<double, 3, 4> blended_motion(const JointWeights& weights,
                                           const std::vector<Eigen::Isometry3d>& world_from_rest, int vertex);

/// "" for rows of weights as above, to 1e-6; otherwise what is wrong with the first that is not: "[3] sums to 0.9
/// instead of 1".
std::string weights_defect(const Eigen::Ref<const RowMatrix>& dense);
/// The same for parents: a tree with root 0, every parent before its children.
std::string parents_defect(const std::vector<int>& parents);

}  // namespace ndg
