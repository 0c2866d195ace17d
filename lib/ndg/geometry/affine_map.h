// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace ndg {

/// An affine map of points: x = M (u, 1).
using AffineMap = Eigen::Matrix<double, 3, 4>;

}  // namespace ndg
