// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace ndg {

/// Lame parameters in pascal.
struct Lame {
    double mu = 0, lambda = 0;
};
/// mu = E / (2 (1 + nu)), lambda = E nu / ((1 + nu) (1 - 2 nu)).
Lame lame_parameters(double young_modulus_pascal, double poisson_ratio);

/// Stiffness of flesh and skin; defaults of NDG 3.2.
struct MaterialOptions {
    /// "paper": flesh resists by the averaged deformation gradient of every prism alone (NDG equation 3), which does
    /// not see the prism's hourglass modes, so that some end inverted. "inversion-free": by the prism's exact volume
    /// too, below a quarter of its rest volume (volume_guard.h).
    std::string energy = "paper";
    double young_muscle_pascal = 45e3;
    double young_fat_pascal = 15e3;
    double poisson_ratio = 0.47;
    double flesh_stiffness = 1.0;     ///< k_f
    double stretch_stiffness = 3e-2;  ///< k_s, joule
    double bend_stiffness = 2e-3;     ///< k_b, joule

    /// Throws InputError naming the value out of range. Poisson's ratio must lie in (1/8, 1/2): with the material as
    /// published the bulk modulus at rest is lambda - mu / 3, which vanishes at 1/8.
    void check() const;
    bool guards_volume() const { return energy == "inversion-free"; }
};

}  // namespace ndg
