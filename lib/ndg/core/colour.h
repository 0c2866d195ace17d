// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace ndg {

/// N x 3 colours, one a vertex, sRGB in [0, 1].
using VertexColours = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// sRGB transfer function and its inverse (IEC 61966-2-1), values in [0, 1].
float srgb_from_linear(float value);
float linear_from_srgb(float value);
Eigen::Vector3f linear_from_srgb(const Eigen::Vector3f& colour);

}  // namespace ndg
