// SPDX-License-Identifier: Apache-2.0
#include "ndg/elastic/materials.h"

#include "ndg/core/error.h"

#include <cmath>

namespace ndg {

Lame lame_parameters(double young_modulus_pascal, double poisson_ratio)
{
    return {young_modulus_pascal / (2 * (1 + poisson_ratio)),
            young_modulus_pascal * poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio))};
}

void MaterialOptions::check() const
{
    require_input(energy == "paper" || energy == "inversion-free",
                  "energy is \"{}\", it must be \"paper\" or \"inversion-free\"", energy);
    const auto positive = [](const char* name, double value) {
        require_input(std::isfinite(value) && value > 0, "{} is {}, it must be positive", name, value);
    };
    positive("young-muscle", young_muscle_pascal);
    positive("young-fat", young_fat_pascal);
    positive("flesh-stiffness", flesh_stiffness);
    require_input(std::isfinite(stretch_stiffness) && stretch_stiffness >= 0,
                  "stretch-stiffness is {}, it must not be negative", stretch_stiffness);
    require_input(std::isfinite(bend_stiffness) && bend_stiffness >= 0, "bend-stiffness is {}, it must not be negative",
                  bend_stiffness);
    require_input(poisson_ratio > 0.125 && poisson_ratio < 0.5,
                  "poisson-ratio is {}, it must lie between 0.125 and 0.5", poisson_ratio);
}

}  // namespace ndg
