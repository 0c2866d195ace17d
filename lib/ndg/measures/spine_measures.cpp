// SPDX-License-Identifier: Apache-2.0
#include "ndg/body_source/bone_cover.h"
#include "ndg/core/angles.h"
#include "ndg/measures/measured_parts.h"
#include "ndg/placement/trunk_bones.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace ndg {
namespace {

/// m; about the depth that the body's own body mass index tells.
constexpr double depth_tolerance = 0.012;

/// From C7 down; index is the level of spinous_depth.
constexpr std::array<const char*, level_l5 + 1> vertebrae = {
    "seventh cervical", "first thoracic",   "second thoracic", "third thoracic", "fourth thoracic", "fifth thoracic",
    "sixth thoracic",   "seventh thoracic", "eighth thoracic", "ninth thoracic", "tenth thoracic",  "eleventh thoracic",
    "twelfth thoracic", "first lumbar",     "second lumbar",   "third lumbar",   "fourth lumbar",   "fifth lumbar"};

std::string level_name(int level)
{
    return level == level_c7 ? "C7" : level < level_l1 ? fmt::format("T{}", level) : fmt::format("L{}", level - 12);
}

/// Middle of the front third of a vertebra, which is the front of its body.
Eigen::Vector3d front_of_body(const Points& vertebra)
{
    return middle(between_shares(vertebra, Eigen::Vector3d::UnitZ(), 2.0 / 3.0, 1.0));
}

/// Slope of the sacrum's upper end plate, radians, positive where it faces forward: from the promontory, its front
/// edge, to the highest place behind it, one to two hundredths of the stature away (end plates are 30 to 35 mm deep).
double sacral_slope(const Points& sacrum, double stature_m)
{
    const Points middle_part = between_shares(sacrum, Eigen::Vector3d::UnitX(), 0.38, 0.62);
    const Eigen::Vector3d promontory = farthest(middle_part, Eigen::Vector3d(0.0, 1.0, 1.0));
    double slope = -0.5 * M_PI;
    for (Eigen::Index v = 0; v < middle_part.rows(); ++v) {
        const double behind = promontory.z() - middle_part(v, 2), above = middle_part(v, 1) - promontory.y();
        if (behind > 0.01 * stature_m && behind < 0.02 * stature_m) slope = std::max(slope, std::atan2(above, behind));
    }
    return slope;
}

/// Lean of the upward direction from `below` to `above` against the vertical, radians, forward positive.
double lean(const Eigen::Vector3d& below, const Eigen::Vector3d& above)
{
    return std::atan2(above.z() - below.z(), above.y() - below.y());
}

}  // namespace

void add_spine_measures(const MeasuredBones& body, MeasureTable& table)
{
    std::vector<std::string> names;
    for (const char* vertebra : vertebrae) names.push_back(std::string(vertebra) + " vertebra");
    if (!body.has(names)) return;
    std::vector<Eigen::Vector3d> fronts;
    for (int level = level_c7; level <= level_l5; ++level) {
        const Points& vertebra = body.bone(names[level]);
        fronts.push_back(front_of_body(vertebra));
        const double expected = spinous_depth(level, body.bmi);
        table.add_gate(
            {level_name(level) + " spinous process, depth", "tip of the process to the skin", MeasureUnit::millimetre,
             "by body mass index: Kawchuk 2011, Ravi 2011, CT of 649 (bone_cover.h)"},
            body.depth(spinous_tip(vertebra)), std::max(0.0, expected - depth_tolerance), expected + depth_tolerance);
    }
    // Tangents of the curve through the fronts of the bodies, as inclinometers on the back take them.
    const double upper = lean(fronts[level_t1 + 1], fronts[level_c7]),
                 lower = lean(fronts[level_l1], fronts[level_t12 - 1]);
    table.add_gate({"thoracic kyphosis T1 to T12", "between tangents of the curve of the vertebral bodies",
                    MeasureUnit::degree, "20 to 60, Scoliosis Research Society; 40 +- 10, Lang-Tapia 2011"},
                   upper - lower, 20.0 * radians_per_degree, 60.0 * radians_per_degree);
    if (!body.has({"sacrum"})) return;
    const double sacral = sacral_slope(body.bone("sacrum"), body.stature_m);
    table.add_gate({"lumbar lordosis T12 to S1", "from the curve's tangent at T12 to the sacrum's upper end plate",
                    MeasureUnit::degree, "49.8 +- 11.2, 627 healthy adults, PMC6680033"},
                   sacral - lower, Spread{49.8 * radians_per_degree, 11.2 * radians_per_degree},
                   Spread{49.8 * radians_per_degree, 11.2 * radians_per_degree});
}

}  // namespace ndg
