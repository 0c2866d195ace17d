// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/pose_set.h"

namespace ndg {

/// The poses of one clip at another rate, up or down, over the same time: from the first pose to the last, as far as
/// whole frames go. Between two poses every joint's rotation is interpolated on the shorter great circle of unit
/// quaternions (Shoemake 1985), the root's displacement linearly. A frame at the time of a pose is that pose, exactly;
/// frames that the clip lacks (dropped as glitches) are filled in. `frame_rate` Hz, 0: the clip's own. In the result
/// frame_idx count from 0 at the new rate, which is the clip's. No poses give none. Throws Error for poses of several
/// clips.
PoseSet resample_poses(const PoseSet& poses, double frame_rate);

}  // namespace ndg
