// SPDX-License-Identifier: Apache-2.0
// Comparisons of a retargeted frame with its source.
#pragma once

#include "ndg/retarget/retarget_transfer.h"

#include <vector>

namespace ndg {

/// Angle (rad) by which the rotation of the source's joint b against its joint a (-1: the world) changes from frame
/// `frame_idx` - 1 to `frame_idx`.
double relative_jump(const MotionClip& clip, int frame_idx, int a, int b);

/// Angle (rad) between the bones that the map aligns, from joint to joint, in the source and in ours; mean over the
/// bones. `rest`: J x 3 joint positions, `parent_from_joint`: J local rotations.
double direction_error(const RotationTransfer& transfer, const Points& rest,
                       const std::vector<Eigen::Matrix3d>& parent_from_joint, int frame_idx);

}  // namespace ndg
