// SPDX-License-Identifier: Apache-2.0
#include "ndg/procedural/parameters.h"

#include "ndg/body_source/adult_statistics.h"
#include "ndg/core/error.h"
#include "ndg/core/random.h"

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

void check_range(const char* name, double value, double low, double high)
{
    require_input(std::isfinite(value) && value >= low && value <= high,
                  "procedural body: {} is {}, allowed is {} to {}", name, value, low, high);
}

}  // namespace

void ProceduralParameters::check() const
{
    check_range("stature_m", stature_m, 1.4, 2.05);
    require_input(std::isfinite(mass_kg) && mass_kg > 0.0, "procedural body: mass_kg is {}, it must be positive",
                  mass_kg);
    check_range("body mass index (mass_kg / stature_m^2)", bmi(), 16.0, max_procedural_bmi);
    check_range("sex", sex, 0.0, 1.0);
    check_range("muscularity", muscularity, 0.0, 1.0);
    check_range("arm_length", arm_length, 0.9, 1.1);
    check_range("leg_length", leg_length, 0.93, 1.07);
    check_range("shoulder_breadth", shoulder_breadth, 0.9, 1.1);
    check_range("hip_breadth", hip_breadth, 0.9, 1.1);
}

ProceduralParameters sample_procedural_parameters(std::uint64_t seed, int body_idx, double min_bmi, double max_bmi)
{
    const Adult adult = sample_adult(seed, body_idx, min_bmi, max_bmi);
    Random random(seed, "procedural bodies", static_cast<std::uint64_t>(body_idx));
    const auto normal = [&](double mean, double deviation, double low, double high) {
        return std::clamp(mean + deviation * random.normal(), low, high);
    };
    ProceduralParameters p;
    const bool male = adult.male;
    p.sex = male ? normal(0.95, 0.08, 0.8, 1.0) : normal(0.05, 0.08, 0.0, 0.2);
    p.age_years = adult.age_years;
    p.stature_m = adult.stature_m;
    p.mass_kg = adult.mass_kg();
    p.muscularity = normal(male ? 0.52 : 0.42, 0.15, 0.05, 0.95);
    p.arm_length = normal(1.0, 0.025, 0.92, 1.08);
    p.leg_length = normal(1.0, 0.02, 0.94, 1.06);
    p.shoulder_breadth = normal(1.0, 0.025, 0.92, 1.08);
    p.hip_breadth = normal(1.0, 0.025, 0.92, 1.08);
    return p;
}

}  // namespace ndg
