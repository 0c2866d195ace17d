// SPDX-License-Identifier: Apache-2.0
// Motion-capture files as they are: their own skeleton, unit and joint names.
#pragma once

#include "ndg/core/types.h"

#include <string>
#include <vector>

namespace ndg {

/// A skeleton and its frames, in the file's unit and axes, after all file conventions (Euler orders, axis frames,
/// degrees) are resolved: every joint has, at the file's zero pose, a frame aligned with the file's world axes.
struct MotionClip {
    std::string name;                                       ///< file name without folder and extension
    std::vector<std::string> joint_names;                   ///< J; the root first
    std::vector<int> parents;                               ///< J; parent before child, -1 for the root
    Points zero_pose_positions;                             ///< J x 3, joint positions at the zero pose, root at origin
    Points zero_pose_tips;                                  ///< J x 3, end of each joint's bone at the zero pose
    double frame_rate = 0.0;                                ///< frames a second
    bool frame_rate_assumed = false;                        ///< true where the file does not store it (AMC: 120)
    std::vector<std::vector<Eigen::Matrix3d>> world_from_joint;  ///< frames x J rotations; identity at the zero pose
    Points root_positions;                                  ///< frames x 3
    double metres_per_unit = 0.0;                           ///< from the file (ASF); 0 where the file does not say
};

/// Biovision hierarchy. Euler order from CHANNELS. Joint frame semantics: see MotionClip.
/// Throws InputError naming file, line and value: unknown keyword, too few channel values, no frames, non-finite.
MotionClip read_bvh(const std::string& path);

/// Acclaim skeleton and motion. Throws InputError as read_bvh does.
MotionClip read_asf_amc(const std::string& asf_path, const std::string& amc_path);

}  // namespace ndg
