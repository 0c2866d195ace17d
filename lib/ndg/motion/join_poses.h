// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/pose_set.h"

#include <vector>

namespace ndg {

/// All poses of several sets in their order, spliced ones last, without covering radii. Clips of one name in several
/// sets become "walk", "walk 2"...: each set's clips stay its own.
PoseSet join_poses(const std::vector<PoseSet>& sets);

}  // namespace ndg
