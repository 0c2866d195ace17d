// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/options.h"

namespace ndg {

/// Lame parameters in pascal.
struct Lame {
    double mu = 0, lambda = 0;
};
/// mu = E / (2 (1 + nu)), lambda = E nu / ((1 + nu) (1 - 2 nu)).
Lame lame_parameters(double young_modulus_pascal, double poisson_ratio);

/// paper: flesh resists by the averaged deformation gradient of every prism alone (NDG equation 3), which does not see
/// the prism's hourglass modes, so that some end inverted and many folded over at a corner. inversion_free: by the
/// prism's exact volume and its corners' Jacobians too, where they are a small share of those at rest (volume_guard.h).
enum class FleshEnergy { paper, inversion_free };
template <>
inline constexpr EnumName<FleshEnergy> enum_table<FleshEnergy>[] = {{FleshEnergy::paper, "paper"},
                                                                    {FleshEnergy::inversion_free, "inversion-free"}};

/// Stiffness of flesh and skin; defaults of NDG 3.2.
struct MaterialOptions {
    FleshEnergy energy = FleshEnergy::inversion_free;
    double young_muscle_pascal = 45e3;
    double young_fat_pascal = 15e3;
    double poisson_ratio = 0.47;
    double flesh_stiffness = 1.0;     ///< k_f
    double stretch_stiffness = 3e-2;  ///< k_s, joule
    double bend_stiffness = 2e-3;     ///< k_b, joule

    bool guards_volume() const { return energy == FleshEnergy::inversion_free; }
};
/// Poisson's ratio must keep inside (1/8, 1/2): with the material as published (Smith, de Goes and Kim 2018, its
/// parameters taken as Lame's) the bulk modulus at rest is lambda - mu / 3, which vanishes at 1/8, and lambda is
/// infinite at 1/2. The range ends where flesh still resists compression and lambda is 5000 times mu. Young's moduli
/// may be next to nothing, for skin alone.
void describe(OptionList& list, MaterialOptions& options);

}  // namespace ndg
