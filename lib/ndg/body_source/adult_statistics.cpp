// SPDX-License-Identifier: Apache-2.0
#include "ndg/body_source/adult_statistics.h"

#include "ndg/core/error.h"
#include "ndg/core/random.h"

#include <cmath>

namespace ndg {
namespace {

constexpr double min_age_years = 20.0, max_age_years = 75.0;
constexpr double min_stature_m = 1.45, max_stature_m = 2.00;
constexpr double least_bmi_range = 1.0;

}  // namespace

double AdultStatistics::log_bmi_mean() const
{
    return std::log(mean_bmi) - 0.5 * log_bmi_deviation * log_bmi_deviation;
}

const AdultStatistics& adult_statistics(bool male)
{
    static const AdultStatistics men{1.753, 0.075, 29.4, 0.217, 0.430, 0.069};
    static const AdultStatistics women{1.613, 0.070, 29.7, 0.260, 0.419, 0.115};
    return male ? men : women;
}

Adult sample_adult(std::uint64_t seed, int body_idx, double min_bmi, double max_bmi)
{
    require_input(body_idx >= 0, "body index {} is negative", body_idx);
    require_input(
        min_bmi >= 14.0 && max_bmi <= 50.0 && max_bmi - min_bmi >= least_bmi_range,
        "adults of a body mass index from {} to {} cannot be drawn, allowed is a range of at least {} within 14 "
        "to 50",
        min_bmi, max_bmi, least_bmi_range);
    Random random(seed, "adults", static_cast<std::uint64_t>(body_idx));
    Adult adult;
    adult.male = body_idx % 2 == 1;
    const AdultStatistics& statistics = adult_statistics(adult.male);
    adult.age_years = random.uniform(min_age_years, max_age_years);
    do {
        adult.stature_m = statistics.mean_stature_m + statistics.stature_deviation_m * random.normal();
    } while (adult.stature_m < min_stature_m || adult.stature_m > max_stature_m);
    do {
        adult.bmi = std::exp(statistics.log_bmi_mean() + statistics.log_bmi_deviation * random.normal());
    } while (adult.bmi < min_bmi || adult.bmi > max_bmi);
    return adult;
}

}  // namespace ndg
