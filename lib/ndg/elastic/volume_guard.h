// SPDX-License-Identifier: Apache-2.0
// Energy that keeps prisms from inverting; an addition to the paper, whose flesh energy has no such term. It sees the
// exact volume V of a prism, and with it the hourglass modes that the averaged deformation gradient does not:
//   psi(v) = k lambda ((t - v) / t)^3 for v = V / V_rest < t, otherwise zero; twice continuously differentiable and
// finite beyond inversion, so that an inverted start is drawn back. A corner may be folded over while the volume is
// not: each of the six has a sixth of the prism's share of the same energy, with v its Jacobian over that at rest and
// its own t and k.
#pragma once

#include "ndg/geometry/prism.h"

namespace ndg {

/// t: prisms squeezed to less than this share of their rest volume are guarded.
constexpr double guarded_volume_share = 0.25;
/// k: at volume zero the pressure is 3 k / t times lambda.
constexpr double volume_guard_stiffness = 2;
/// The same of a corner. Corners are squeezed more than prisms, in all folds.
constexpr double guarded_corner_share = 0.2, corner_guard_stiffness = 0.5;

/// Per volume of flesh and in units of lambda: energy and its derivatives by v.
struct VolumeGuard {
    double energy = 0, first = 0, second = 0;
};
VolumeGuard volume_guard(double volume_share);
VolumeGuard corner_guard(double corner_share);

}  // namespace ndg
