// SPDX-License-Identifier: Apache-2.0
#include "ndg/elastic/volume_guard.h"

namespace ndg {

VolumeGuard volume_guard(double volume_share)
{
    VolumeGuard guard;
    if (volume_share >= guarded_volume_share) return guard;
    const double depth = 1 - volume_share / guarded_volume_share;
    guard.energy = volume_guard_stiffness * depth * depth * depth;
    guard.first = -3 * volume_guard_stiffness * depth * depth / guarded_volume_share;
    guard.second = 6 * volume_guard_stiffness * depth / (guarded_volume_share * guarded_volume_share);
    return guard;
}

}  // namespace ndg
