// SPDX-License-Identifier: Apache-2.0
// VertexNet (NDG section 5.2.1, after Han et al. 2024): offsets of vertices at rest, then linear blend skinning.
#pragma once

#include "ndg/neural/output_space.h"

#include <Eigen/Core>

namespace ndg {

/// Offsets of the free vertices (muscle wrap, then skin; 2 N_w x 3), in the rest pose, in mm; neutral: none, that is,
/// linear blend skinning. Vertices are those of X = LBS(X_rest + offsets) (NDG equation 21), the bone wrap that of the
/// posed body. The paper's PCA decoder is the model's output basis (NetworkOptions::output_basis).
std::unique_ptr<OutputSpace> make_vertex_offsets(const Template& body_template, const NetworkOptions& options);

/// Smallest stretch of a blend of joint motions that is undone as it is.
constexpr double least_blend_stretch = 0.2;

/// The way back through a blend of joint motions with this linear part: its inverse, where no direction is stretched by
/// less than `least`. Blends of opposed rotations collapse directions, and an inverse would ask for offsets without
/// bound: there a stretch s is undone by s / least^2 instead of 1 / s, which is continuous and at most 1 / least.
Eigen::Matrix3d bounded_inverse(const Eigen::Matrix3d& blend, double least = least_blend_stretch);

}  // namespace ndg
