// SPDX-License-Identifier: Apache-2.0
// Nearest rotations of many deformation gradients, eight at a time in single precision.
#pragma once

#include "ndg/deform/residuals.h"

namespace ndg {

/// Row p: the rotation R nearest to F_p, argmin |F_p - R|^2 over SO(3), also where F_p is flat or turned inside out.
///
/// The quaternion of R is the eigenvector of the largest eigenvalue of a symmetric 4 x 4 matrix that is linear in F
/// (Davenport 1968). Newton's method on the characteristic polynomial, which falls onto the largest root from above,
/// finds the eigenvalue (QUEST: Shuster and Oh 1981), a column of the adjugate the eigenvector. Distances |F - R|^2 are
/// right to some 1e-6 |F|^2; where the nearest rotation is all but ambiguous (the two largest eigenvalues meet), a
/// singular value decomposition in double precision decides.
Gradients nearest_rotations(const Eigen::Ref<const Gradients>& gradients);

}  // namespace ndg
