// SPDX-License-Identifier: Apache-2.0
// How stress changes with what is estimated of a material (elastic/orthotropic_material.h).
#pragma once

#include "ndg/elastic/orthotropic_material.h"

namespace ndg {

/// d / dY of what the law takes from the moduli (Romero et al. 2020, equation 5).
struct MaterialDerivative {
    double mu = 0, lambda = 0;                          ///< of d mu / dY and d lambda / dY, Pa/Pa
    Eigen::Matrix3d weights = Eigen::Matrix3d::Zero();  ///< d tau / dY, 1/Pa
};

/// By the modulus along the normal, by the one across it, or by both where they are one.
enum class Modulus { normal, tangent, both };

/// Where both moduli are equal, mu takes the larger one: the derivatives are those of a normal modulus that grows
/// and a tangential one that falls. Throws Error as orthotropic_material does.
MaterialDerivative material_derivative(const OrthotropicModuli& moduli, Modulus by);

/// d^2 psi / (dF dY), Pa/Pa.
Eigen::Matrix3d stress_derivative(const Eigen::Matrix3d& deformation, const OrthotropicMaterial& material,
                                  const MaterialDerivative& derivative);

}  // namespace ndg
