// SPDX-License-Identifier: Apache-2.0
// Motion capture onto the standard skeleton by direct rotation transfer.
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/motion/joint_map.h"

#include <string>
#include <vector>

namespace ndg {

struct RetargetOptions {
    double frame_rate = 10.0;  ///< Hz, poses kept a second; 0 keeps every frame
    /// rad/s; a frame is dropped as a glitch where a joint turns faster than this from the frame before or to the next.
    double max_joint_speed = 26.179938779914945;  // 1500 degrees a second
    /// rad; frames in which a joint other than the root is rotated further from rest are dropped. Pi: none.
    double max_joint_angle = 3.141592653589793;
};

/// What was done to a clip.
struct RetargetReport {
    std::string clip_name;
    int num_frames = 0;                 ///< in the file
    int num_skipped = 0;                ///< at the start, because the joint map says so
    int num_glitch_frames = 0;          ///< of the file: frames next to a jump
    int num_dropped_glitches = 0;       ///< candidates at the chosen rate lost to glitches
    int num_dropped_angles = 0;         ///< candidates lost to max_joint_angle or a limit of the joint map
    int num_poses = 0;                  ///< kept
    double mean_direction_error = 0.0;  ///< rad, between aligned bones of the source and ours, over the kept poses
    double max_joint_speed = 0.0;       ///< rad/s, fastest local joint rotation between neighbouring frames of the file
};

/// Poses of one clip. For joint j with source rotation R_src (blended where the map says so) the world rotation is
/// R_src A_j, where A_j takes our rest bone (joint_positions, A pose) to the source's bone at its zero pose, built down
/// the chain by minimal rotations from the parent's alignment, so that bones point as in the source without arbitrary
/// twist; unmapped joints follow their parent. The root is placed so that the midpoint of the hips follows the
/// source's, scaled by the ratio of leg lengths, starting above the origin. `joint_positions`: J x 3 rest positions of
/// the body. Throws InputError naming clip and item: map that does not fit, bone of zero length.
PoseSet retarget_clip(const MotionClip& clip, const JointMap& map, const Eigen::Ref<const Points>& joint_positions,
                      const RetargetOptions& options, RetargetReport& report);

/// A_j of every joint of ours, J rotations (see retarget_clip).
std::vector<Eigen::Matrix3d> rest_alignment(const MotionClip& clip, const JointMap& map,
                                            const Eigen::Ref<const Points>& joint_positions);

/// Appends the clips and poses of `addition`.
void append_poses(PoseSet& poses, const PoseSet& addition);

}  // namespace ndg
