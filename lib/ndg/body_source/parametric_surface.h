// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"

namespace ndg {

/// One person as a parametric source gives it: a closed skin with skeleton, before any layers. SI units, y up, faces
/// +z, feet on y = 0, pelvis above the origin.
struct ParametricSurface {
    Points vertices;         ///< N x 3
    Triangles triangles;     ///< T x 3, closed and outward
    Points joint_positions;  ///< J x 3 on the standard skeleton
};

/// Height of the surface above the floor, m.
double stature(const Eigen::Ref<const Points>& vertices);

/// Density of the living human body used to turn volume into mass, kg/m^3 (Durnin and Womersley 1974 measured 1.02 to
/// 1.08 for lean to 0.98 for obese adults without lung air; 1010 is the usual average with lung air left in).
constexpr double body_density = 1010.0;

}  // namespace ndg
