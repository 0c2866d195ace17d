// SPDX-License-Identifier: Apache-2.0
// Stable Neo-Hookean flesh without the barrier term (NDG equation 3; Smith, de Goes and Kim 2018):
//   psi(F) = mu/2 (|F|^2 - 3) + lambda/2 (det F - alpha)^2 - lambda/2 (1 - alpha)^2,  alpha = 1 + mu / lambda.
// The last term makes psi(I) = 0. Matrices of 9 take F column by column: entry i + 3 j is F_ij.
#pragma once

#include "ndg/elastic/materials.h"

#include <Eigen/Core>

namespace ndg {

using Matrix9 = Eigen::Matrix<double, 9, 9>;

/// psi(F), J/m^3.
double neo_hookean_energy(const Eigen::Matrix3d& deformation, const Lame& lame);
/// First Piola-Kirchhoff stress d psi / d F, Pa.
Eigen::Matrix3d neo_hookean_stress(const Eigen::Matrix3d& deformation, const Lame& lame);
/// d^2 psi / d F^2.
Matrix9 neo_hookean_hessian(const Eigen::Matrix3d& deformation, const Lame& lame);
/// Smallest eigenvalue of the Hessian among its twist and flip modes, over mu: the others are rarely smaller.
double neo_hookean_stability(const Eigen::Matrix3d& deformation, const Lame& lame);
/// M with M M^T the Hessian with negative eigenvalues set to zero: its eigenvectors, scaled by the roots of their
/// eigenvalues, one a column.
Matrix9 neo_hookean_projected_modes(const Eigen::Matrix3d& deformation, const Lame& lame);
/// The Hessian with negative eigenvalues set to zero, by its analytic eigensystem in the frame of the singular vectors.
Matrix9 neo_hookean_projected_hessian(const Eigen::Matrix3d& deformation, const Lame& lame);

}  // namespace ndg
