// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/template.h"

#include <string>

namespace ndg {

/// Who the skin belongs to, as far as the amount of fat depends on it.
struct Person {
    double sex = 0.5;  ///< 0 female, 1 male
    double age_years = 30.0;
};

/// Measures of a layered body.
struct LayerReport {
    double stature_m = 0, mass_kg = 0, bmi = 0;
    double body_fat_share = 0;   ///< wanted, of the mass (Deurenberg et al. 1991)
    double fat_layer_share = 0;  ///< reached: fat layer mass / body mass
    double muscle_layer_litre = 0, fat_layer_litre = 0;
    double min_scaled_jacobian = 0;
    int adjusted_vertices = 0;
};

/// Fraction of body mass that is fat: 1.2 BMI + 0.23 age - 10.8 sex - 5.4 percent (Deurenberg, Weststrate and Seidell,
/// Br. J. Nutr. 65, 1991), kept within 5 to 60 percent.
double body_fat_share(double bmi, const Person& person);

/// Layers for a skin in the template's tessellation: `skin.skin_vertices` and `skin.joint_positions` are given, the
/// rest is filled. The bone wrap keeps the template's distance to the skeleton scaled by stature (bones do not grow
/// with fat), the muscle wrap is placed so that the fat layer holds the wanted share of the mass. Throws Error when no
/// valid layers are found.
Body build_layers(const Template& body_template, const Body& skin, const Person& person, double min_scaled_jacobian,
                  LayerReport* report = nullptr);

/// Layers for all skins, in parallel; persons from the skins' parameters "sex" and "age_years" (InputError naming
/// `skins_path` when it has none). The parameters of the result are the report's figures. One failing body stops the
/// batch with its error.
BodySet build_layers(const Template& body_template, const BodySet& skins, const std::string& skins_path,
                     double min_scaled_jacobian);

}  // namespace ndg
