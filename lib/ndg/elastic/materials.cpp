// SPDX-License-Identifier: Apache-2.0
#include "ndg/elastic/materials.h"

namespace ndg {

Lame lame_parameters(double young_modulus_pascal, double poisson_ratio)
{
    return {young_modulus_pascal / (2 * (1 + poisson_ratio)),
            young_modulus_pascal * poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio))};
}

void describe(OptionList& list, MaterialOptions& options)
{
    list.add("energy", options.energy, "flesh energy; inversion-free guards volume and corners of every prism too");
    list.add("young-muscle", options.young_muscle_pascal, "Young's modulus of the muscle layer, Pa", 1e-12, 1e9);
    list.add("young-fat", options.young_fat_pascal, "Young's modulus of the fat layer, Pa", 1e-12, 1e9);
    list.add("poisson-ratio", options.poisson_ratio, "Poisson's ratio of both layers", 0.13, 0.4999);
    list.add("flesh-stiffness", options.flesh_stiffness, "factor k_f of the flesh energy", 1e-6, 1e6);
    list.add("stretch-stiffness", options.stretch_stiffness, "factor k_s of skin stretching, J", 0, 1e6);
    list.add("bend-stiffness", options.bend_stiffness, "factor k_b of skin bending, J", 0, 1e6);
}

}  // namespace ndg
