// SPDX-License-Identifier: Apache-2.0
// How tall and how heavy adults are.
#pragma once

#include <cstdint>

namespace ndg {

/// Stature is normal, body mass index log-normal and independent of it. Means: measured adults of 20 years and more
/// (Fryar, Carroll, Gu, Afful and Ogden 2021, Anthropometric reference data for children and adults: United States,
/// 2015-2018, NCHS Vital Health Stat 3(46)). The spread of the index is the one with which the shares of obesity (30
/// and more) and severe obesity (40 and more) come out as measured in 2017-2018 (Hales, Carroll, Fryar and Ogden 2020,
/// Prevalence of obesity and severe obesity among adults, NCHS Data Brief 360).
struct AdultStatistics {
    double mean_stature_m, stature_deviation_m;
    double mean_bmi, log_bmi_deviation;  ///< kg/m^2; of the natural logarithm
    double published_obese, published_severely_obese;

    /// Mean of the logarithm of the index.
    double log_bmi_mean() const;
};
const AdultStatistics& adult_statistics(bool male);

/// An adult drawn from them.
struct Adult {
    bool male = false;
    double age_years = 0, stature_m = 0, bmi = 0;
    double mass_kg() const { return bmi * stature_m * stature_m; }
};

/// Adult `body_idx` of a population: sexes alternate, women first; age uniform from 20 to 75 years; those whose stature
/// lies outside 1.45 to 2.00 m or body mass index outside [min_bmi, max_bmi] are drawn again. Depends on
/// (seed, body_idx) and the bounds alone. Throws InputError for bounds that leave nothing.
Adult sample_adult(std::uint64_t seed, int body_idx, double min_bmi, double max_bmi);

}  // namespace ndg
