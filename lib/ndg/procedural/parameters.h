// SPDX-License-Identifier: Apache-2.0
// What one can ask of the procedural body, and adults drawn from published statistics.
#pragma once

#include <cstdint>

namespace ndg {

/// An adult. The four ratios are relative to the mean adult of that stature.
struct ProceduralParameters {
    double stature_m = 1.70;
    double mass_kg = 66.0;
    double sex = 0.5;               ///< 0 female, 1 male
    double muscularity = 0.5;       ///< 0 slight, 1 athletic; at the same mass more muscle means less fat
    double arm_length = 1.0;        ///< ratio, 0.9 to 1.1
    double leg_length = 1.0;        ///< ratio, 0.93 to 1.07; the trunk makes up for it, so that stature stays
    double shoulder_breadth = 1.0;  ///< ratio, 0.9 to 1.1
    double hip_breadth = 1.0;       ///< ratio, 0.9 to 1.1
    double age_years = 40.0;        ///< for what depends on it elsewhere; the shape does not

    double bmi() const { return mass_kg / (stature_m * stature_m); }
    /// Throws InputError naming the parameter and its value: stature outside 1.4 to 2.05 m, BMI outside 16 to
    /// max_procedural_bmi kg/m^2, a ratio outside its range.
    void check() const;
};

/// Largest body mass index that the body shows without folds at the armpits.
constexpr double max_procedural_bmi = 35.0;

/// Adult `body_idx` of a population (sample_adult, cut to [min_bmi, max_bmi]). Segment lengths and breadths vary by 2
/// to 2.5 % at given stature (Gordon et al. 2014, ANSUR II). Depends on (seed, body_idx) and the bounds alone.
ProceduralParameters sample_procedural_parameters(std::uint64_t seed, int body_idx, double min_bmi = 17.0,
                                                  double max_bmi = max_procedural_bmi);

}  // namespace ndg
