// SPDX-License-Identifier: Apache-2.0
#include "ndg/body_source/bone_cover.h"

#include <algorithm>
#include <array>

namespace ndg {
namespace {

constexpr double mean_bmi = 27.2;
constexpr double least_depth = 0.006;  ///< m

/// m at mean_bmi, by level.
constexpr std::array<double, 18> depths = {0.018,  0.018,  0.017,  0.016,  0.016,  0.016,  0.016,  0.016,  0.016,
                                           0.0165, 0.0175, 0.0195, 0.0215, 0.0228, 0.0230, 0.0274, 0.0334, 0.0367};
/// m per kg/m^2 of the thoracic and lumbar levels.
constexpr double thoracic_slope = 0.0009, lumbar_slope = 0.00098;

}  // namespace

double spinous_depth(double level, double bmi)
{
    const double at = std::clamp(level, 0.0, double(level_l5));
    const int below = std::min(int(at), level_l5 - 1);
    const double share = at - below;
    const double mean = (1.0 - share) * depths[below] + share * depths[below + 1];
    const double slope = at <= level_t12 ? thoracic_slope : lumbar_slope;
    return std::max(least_depth, mean + slope * (bmi - mean_bmi));
}

double sternum_depth(double bmi)
{
    return std::max(0.005, 0.008 + 0.0005 * (bmi - mean_bmi));
}

double rib_side_depth(double bmi)
{
    return std::max(0.010, 0.020 + 0.0009 * (bmi - mean_bmi));
}

}  // namespace ndg
