// SPDX-License-Identifier: Apache-2.0
// Motions written by hand: clinical joint angles at a few times, on the standard skeleton (configs/motions/*.json).
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/motion/clinical_angles.h"

#include <array>
#include <string>
#include <vector>

namespace ndg {

/// One angle over time.
struct KeyframeTrack {
    int angle = 0;               ///< into clinical_angle_names()
    std::vector<double> times;   ///< s, increasing
    std::vector<double> values;  ///< rad
};

/// What the root's translation is made from.
enum class Ground {
    none,         ///< the root joint stays where it is at rest
    lowest_foot,  ///< up and down, so that the lower foot stands on the floor: gait on a treadmill
    both_feet     ///< the midpoint of the ankles stays where it is at rest too: standing, squatting
};

/// The file is a JSON object:
///  "format": "ndg-keyframes", "licence": text, "description": text (optional),
///  "frame_rate": Hz, "duration": s,
///  "period": s (optional): the tracks describe one cycle, repeated until `duration`,
///  "ground": "none", "lowest_foot" or "both_feet" (optional, "none"),
///  "lift": [[time, metres], ...] (optional): how far above the ground, in jumps; "ground" must not be "none",
///  "stance": {angle: degrees} (optional): values where nothing else is said, otherwise 0,
///  "tracks": {angle: [[time, degrees], ...]} (optional),
///  "poses": [{"time": s, "angles": {angle: degrees}}, ...] (optional): all angles named in any of them get a key in
///      each, of their stance where a pose does not name them.
/// An angle is one of clinical_angle_names(). "both_hip.flexion" stands for left and right;
/// "alternating_hip.flexion" for the left as written and the right half a period later; "left_fingers.curl",
/// "left_fingers.spread" for a fist's and a spread hand's share of the four fingers' angles.
struct KeyframeMotion {
    std::string path, name;  ///< file, and its name without folder and extension
    std::string description, licence;
    double frame_rate = 0.0;  ///< Hz
    double duration = 0.0;    ///< s
    double period = 0.0;      ///< s; 0: not periodic
    Ground ground = Ground::none;
    std::vector<double> stance;  ///< rad, one of each clinical angle
    std::vector<KeyframeTrack> tracks;
    KeyframeTrack lift;  ///< m; without keys on the ground

    int num_frames() const;
    /// Clinical angles at a time, rad. Between keys a cubic without overshoot (Fritsch and Carlson 1980), flat before
    /// the first and after the last.
    std::vector<double> angles(double time) const;
    /// Height above the ground at a time, m.
    double height(double time) const;
};

/// Whether a file is a .json that begins as a motion of ours does.
bool is_keyframe_motion(const std::string& path);

/// Throws InputError naming file, item and value: not JSON, unknown key or angle, times that do not increase or lie
/// outside 0..duration, non-finite numbers, two tracks of one angle.
KeyframeMotion read_keyframe_motion(const std::string& path);

/// Poses of a body with these rest joints (J x 3), as many a second as `poses_per_second` (0: every frame). One clip of
/// the motion's name and frame rate; frame_idx counts its frames.
PoseSet keyframe_poses(const KeyframeMotion& motion, const Eigen::Ref<const Points>& joint_positions,
                       double poses_per_second);

}  // namespace ndg
