// SPDX-License-Identifier: Apache-2.0
// Array types shared by every module. Row-major N x k arrays, one point, element or sample a row.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace ndg {

/// N x 3 positions, one point a row, in metres.
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// T x 3 vertex indices, counter-clockwise seen from outside.
using Triangles = Eigen::Matrix<int, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// T x 4 vertex indices with positive signed volume (x1-x0) x (x2-x0) . (x3-x0) > 0.
using Tetrahedra = Eigen::Matrix<int, Eigen::Dynamic, 4, Eigen::RowMajor>;
/// P x 6 vertex indices: the outer triangle is columns 0-2, the inner one columns 3-5
/// (VTK_WEDGE order for outward-facing triangles, so that det J > 0).
using Prisms = Eigen::Matrix<int, Eigen::Dynamic, 6, Eigen::RowMajor>;
/// General row-major real and integer arrays.
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using RowMatrixF = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using RowMatrixI = Eigen::Matrix<int, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace ndg
