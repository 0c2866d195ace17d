// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"

namespace ndg {

struct Sphere {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    double radius = 0.0;
};

/// Least-squares sphere through points, N x 3, re-weighted (Tukey's biweight) so that points off the sphere, as the
/// neck of a femur below its head, lose their say. Throws Error for fewer than four points or flat ones.
Sphere fit_sphere(const Eigen::Ref<const Points>& points);

}  // namespace ndg
