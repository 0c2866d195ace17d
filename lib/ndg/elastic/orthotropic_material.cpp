// SPDX-License-Identifier: Apache-2.0
#include "ndg/elastic/orthotropic_material.h"

#include "ndg/core/error.h"
#include "ndg/elastic/materials.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>

namespace ndg {

OrthotropicMaterial orthotropic_material(const OrthotropicModuli& moduli, const Eigen::Vector3d& normal)
{
    const double largest = std::max(moduli.young_normal_pascal, moduli.young_tangent_pascal);
    require(std::isfinite(largest) && moduli.young_normal_pascal > 0 && moduli.young_tangent_pascal > 0,
            "Young's moduli of {} Pa along the normal and {} Pa across it are not both positive",
            moduli.young_normal_pascal, moduli.young_tangent_pascal);
    require(moduli.poisson_ratio >= 0 && moduli.poisson_ratio < 0.5, "Poisson's ratio {} is outside of [0, 0.5)",
            moduli.poisson_ratio);
    require(std::isfinite(moduli.saturation) && moduli.saturation > 0, "saturation {} is not positive",
            moduli.saturation);
    const double length = normal.norm();
    require(std::isfinite(length) && length > 1e-9, "a normal of length {} has no direction", length);
    OrthotropicMaterial material;
    const Lame lame = lame_parameters(largest, moduli.poisson_ratio);
    material.mu = lame.mu;
    material.lambda = lame.lambda;
    material.saturation = moduli.saturation;
    const Eigen::Vector3d shares(moduli.young_normal_pascal / largest, moduli.young_tangent_pascal / largest,
                                 moduli.young_tangent_pascal / largest);
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) material.weights(i, j) = std::max(shares[i], shares[j]);
    }
    material.basis.col(0) = normal / length;
    Eigen::Index least = 0;
    normal.cwiseAbs().minCoeff(&least);
    material.basis.col(1) = material.basis.col(0).cross(Eigen::Vector3d::Unit(least)).normalized();
    material.basis.col(2) = material.basis.col(0).cross(material.basis.col(1));
    return material;
}

double orthotropic_energy(const Eigen::Matrix3d& deformation, const OrthotropicMaterial& material)
{
    const Eigen::Matrix3d in_basis = deformation * material.basis;
    const Eigen::Matrix3d strain = 0.5 * (in_basis.transpose() * in_basis - Eigen::Matrix3d::Identity());
    const double sigma = material.weights.cwiseProduct(strain.cwiseAbs2()).sum();
    const double exponent = material.saturation * sigma, dilation = deformation.determinant() - 1;
    if (!(exponent <= largest_exponent)) return std::numeric_limits<double>::infinity();
    return material.mu * std::expm1(exponent) / material.saturation + 0.5 * material.lambda * dilation * dilation;
}

}  // namespace ndg
