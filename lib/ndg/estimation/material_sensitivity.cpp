// SPDX-License-Identifier: Apache-2.0
#include "ndg/estimation/material_sensitivity.h"

#include "ndg/core/error.h"
#include "ndg/elastic/materials.h"

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

/// Columns are the cross products of those of F: d det F / dF.
Eigen::Matrix3d cofactor(const Eigen::Matrix3d& f)
{
    Eigen::Matrix3d result;
    result << f.col(1).cross(f.col(2)), f.col(2).cross(f.col(0)), f.col(0).cross(f.col(1));
    return result;
}

}  // namespace

MaterialDerivative material_derivative(const OrthotropicModuli& moduli, Modulus by)
{
    const double normal = moduli.young_normal_pascal, tangent = moduli.young_tangent_pascal;
    require(normal > 0 && tangent > 0, "Young's moduli of {} and {} Pa are not both positive", normal, tangent);
    // Both are proportional to the larger modulus.
    const Lame of_one = lame_parameters(1, moduli.poisson_ratio);
    MaterialDerivative result;
    if (by == Modulus::both) {
        require(normal == tangent, "moduli of {} and {} Pa are not one", normal, tangent);
        result.mu = of_one.mu;
        result.lambda = of_one.lambda;
        return result;
    }
    const bool normal_is_larger = normal >= tangent;
    const double larger = std::max(normal, tangent), share = std::min(normal, tangent) / larger;
    const bool by_larger = (by == Modulus::normal) == normal_is_larger;
    if (by_larger) {
        result.mu = of_one.mu;
        result.lambda = of_one.lambda;
    }
    const double share_derivative = by_larger ? -share / larger : 1 / larger;
    if (normal_is_larger) {
        result.weights.bottomRightCorner<2, 2>().setConstant(share_derivative);
    } else {
        result.weights(0, 0) = share_derivative;
    }
    return result;
}

Eigen::Matrix3d stress_derivative(const Eigen::Matrix3d& deformation, const OrthotropicMaterial& material,
                                  const MaterialDerivative& derivative)
{
    const Eigen::Matrix3d in_basis = deformation * material.basis;
    const Eigen::Matrix3d strain = 0.5 * (in_basis.transpose() * in_basis - Eigen::Matrix3d::Identity());
    const Eigen::Matrix3d squares = strain.cwiseAbs2();
    const double growth = std::exp(material.saturation * material.weights.cwiseProduct(squares).sum());
    const double sigma_derivative = derivative.weights.cwiseProduct(squares).sum();
    // d sigma / dF = F B (2 tau o E') B^T, and so with d tau.
    const double along_sigma = growth * (derivative.mu + material.mu * material.saturation * sigma_derivative);
    const Eigen::Matrix3d tension =
        2 * (along_sigma * material.weights + growth * material.mu * derivative.weights).cwiseProduct(strain);
    return in_basis * tension * material.basis.transpose() +
           derivative.lambda * (deformation.determinant() - 1) * cofactor(deformation);
}

}  // namespace ndg
