// SPDX-License-Identifier: Apache-2.0
// Motion capture onto the standard skeleton: rotations transferred, then joint positions matched.
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/core/options.h"
#include "ndg/motion/joint_limits.h"
#include "ndg/retarget/inverse_kinematics.h"
#include "ndg/retarget/joint_map.h"
#include "ndg/retarget/retarget_report.h"

#include <vector>

namespace ndg {

struct RetargetOptions {
    double frame_rate = 10.0;  ///< Hz, poses kept a second; 0 keeps every frame
    /// Degrees/s; a frame is dropped as a glitch where a joint turns faster from the frame before or to the next.
    double max_joint_speed = 1500;
    /// Degrees; frames in which a joint other than the root is rotated further from rest are dropped. 180: none.
    double max_joint_angle = 180;
    /// Match joint positions by inverse kinematics; otherwise the rotations are transferred and nothing more.
    bool inverse_kinematics = true;
    InverseKinematicsOptions kinematics;
    const JointLimits* limits = nullptr;  ///< ranges to check against; of the same body
    bool clamp_limits = false;            ///< bring joints to the border of their range
};
void describe(OptionList& list, RetargetOptions& options);

/// Poses of one clip. World rotations are transferred (RotationTransfer), then corrected so that our joints lie where
/// the source has them (ScaledTargets, InverseKinematics), then clamped where asked for. The correction of a frame
/// starts from the one before; clips are cut into pieces of 256 frames, each of which starts anew, so that the result
/// does not depend on the number of threads. The root follows the midpoint of the source's hips, scaled by the ratio of
/// leg lengths, from above the origin. `joint_positions`: J x 3 rest positions of the body. Throws InputError naming
/// clip and item: map that does not fit, bone of zero length, more frames to skip than there are.
PoseSet retarget_clip(const MotionClip& clip, const JointMap& map, const Eigen::Ref<const Points>& joint_positions,
                      const RetargetOptions& options, RetargetReport& report);

/// Appends the clips and poses of `addition`.
void append_poses(PoseSet& poses, const PoseSet& addition);

}  // namespace ndg
