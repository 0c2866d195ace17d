// SPDX-License-Identifier: Apache-2.0
// Skin and flesh of Romero et al. 2020, section 4.3: an orthotropic St. Venant-Kirchhoff material whose stress
// saturates exponentially, after Fung (their equation 4):
//   psi(F) = mu (exp(eta sigma) - 1) / eta + lambda / 2 (det F - 1)^2,  sigma = sum over i, j of tau_ij E'_ij^2,
//   E' = B^T E B,  E = (F^T F - I) / 2.
// Nothing in it resists inversion beyond (det F - 1)^2.
#pragma once

#include "ndg/core/types.h"

namespace ndg {

struct OrthotropicMaterial {
    double mu = 0, lambda = 0;                          ///< Pa
    double saturation = 0;                              ///< eta
    Eigen::Matrix3d weights = Eigen::Matrix3d::Ones();  ///< tau, symmetric, in [0, 1]
    Eigen::Matrix3d basis =
        Eigen::Matrix3d::Identity();  ///< B, a rotation: its columns are the material's axes at rest
};

/// What is estimated of a material (Romero et al., section 4.4), in pascal, and what is fixed of it.
struct OrthotropicModuli {
    double young_normal_pascal = 0, young_tangent_pascal = 0;  ///< Y_N, Y_T
    double poisson_ratio = 0.2, saturation = 4;
};

/// Equation 5 of Romero et al.: mu and lambda of the larger modulus, tau of the shares that the moduli have of it,
/// shear as the stiffer of its two axes. The first axis is `normal`, which need not be of unit length; with equal
/// weights along the other two, their directions do not matter. Throws Error for moduli that are not positive, for a
/// ratio outside of [0, 1/2) and for a normal without direction.
OrthotropicMaterial orthotropic_material(const OrthotropicModuli& moduli, const Eigen::Vector3d& normal);

/// psi(F), J/m^3, of one state; infinite where the exponential is too large (fung_lanes.h).
double orthotropic_energy(const Eigen::Matrix3d& deformation, const OrthotropicMaterial& material);

/// eta sigma above this counts as infinite energy: a stretch of some 4, far beyond what flesh bears, and still far from
/// where squares of exp would overflow.
constexpr double largest_exponent = 300;

}  // namespace ndg
