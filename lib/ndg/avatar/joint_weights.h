// SPDX-License-Identifier: Apache-2.0
// Skinning weights with any number of joints a vertex: what interpolation carries into a volume is blended from many.
#pragma once

#include <Eigen/SparseCore>

namespace ndg {

/// N x K, rows non-negative and summing to one, compressed.
using JointWeights = Eigen::SparseMatrix<double, Eigen::RowMajor>;

}  // namespace ndg
