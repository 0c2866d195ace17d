// SPDX-License-Identifier: Apache-2.0
#include "ndg/elastic/volume_guard.h"

namespace ndg {

namespace {

VolumeGuard cubic_guard(double share, double guarded_share, double stiffness)
{
    VolumeGuard guard;
    if (share >= guarded_share) return guard;
    const double depth = 1 - share / guarded_share;
    guard.energy = stiffness * depth * depth * depth;
    guard.first = -3 * stiffness * depth * depth / guarded_share;
    guard.second = 6 * stiffness * depth / (guarded_share * guarded_share);
    return guard;
}

}  // namespace

VolumeGuard volume_guard(double volume_share)
{
    return cubic_guard(volume_share, guarded_volume_share, volume_guard_stiffness);
}

VolumeGuard corner_guard(double corner_share)
{
    return cubic_guard(corner_share, guarded_corner_share, corner_guard_stiffness);
}

}  // namespace ndg
