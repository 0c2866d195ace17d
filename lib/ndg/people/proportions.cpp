// SPDX-License-Identifier: Apache-2.0
#include "ndg/people/proportions.h"

#include "ndg/body/skeleton.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace ndg {
namespace {

Eigen::RowVector3d joint(const ParametricSurface& surface, const char* name)
{
    return surface.joint_positions.row(standard_skeleton().joint(name));
}

double apart(const ParametricSurface& surface, const char* one, const char* other)
{
    return (joint(surface, one) - joint(surface, other)).norm();
}

std::size_t detail_index(const std::string& name)
{
    const auto& names = makehuman_details();
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

}  // namespace

const std::array<Proportion, num_proportions>& proportions()
{
    static const std::array<Proportion, num_proportions> table = {
        {{"torso/measure-shoulder-dist", 0.023, 0.218, 0.231, 0.010,
          [](const ParametricSurface& s) { return apart(s, "left_upper_arm", "right_upper_arm"); }},
         {"arms/measure-upperarm-length", 0.037, 0.165, 0.165, 0.0065,
          [](const ParametricSurface& s) { return apart(s, "left_upper_arm", "left_forearm"); }},
         {"arms/measure-lowerarm-length", 0.034, 0.145, 0.150, 0.007,
          [](const ParametricSurface& s) { return apart(s, "left_forearm", "left_hand"); }},
         {"legs/measure-lowerleg-height", 0.031, 0.286, 0.280, 0.009,
          [](const ParametricSurface& s) { return joint(s, "left_shin")[1]; }},
         {"legs/measure-upperleg-height", 0.027, 0.519, 0.513, 0.0145,
          [](const ParametricSurface& s) { return joint(s, "left_thigh")[1]; }}}};
    return table;
}

ProportionValues usual_proportions(double sex, const std::array<double, num_proportions>& deviations)
{
    ProportionValues values{};
    for (int k = 0; k < num_proportions; ++k) {
        const Proportion& p = proportions()[k];
        values[k] = (1.0 - sex) * p.female + sex * p.male + deviations[k] * p.deviation;
    }
    return values;
}

void correlate_legs(std::array<double, num_proportions>& deviations)
{
    constexpr int knee = 3, hip = 4;
    deviations[hip] = 0.8 * deviations[knee] + 0.6 * deviations[hip];
}

double approach_proportions(const ParametricSurface& surface, const ProportionValues& wished,
                            MakeHumanParameters& parameters)
{
    const double height = stature(surface.vertices);
    double worst = 0.0;
    for (int k = 0; k < num_proportions; ++k) {
        const Proportion& p = proportions()[k];
        double& detail = parameters.details[detail_index(p.detail)];
        const double miss = wished[k] - p.measure(surface) / height;
        const double next = std::clamp(detail + miss / p.slope, -1.0, 1.0);
        if (std::abs(next) < 1.0) worst = std::max(worst, std::abs(miss));
        detail = next;
    }
    return worst;
}

}  // namespace ndg
