// SPDX-License-Identifier: Apache-2.0
// What bringing a clip onto our skeleton did, for people and for programs.
#pragma once

#include <string>
#include <vector>

namespace ndg {

/// A change of a joint's rotation between neighbouring frames that is called a jump, rad.
constexpr double jump_angle = 3.141592653589793 / 3.0;
/// A joint further outside its range than this counts as a violation, rad.
constexpr double violation_angle = 3.141592653589793 / 180.0;

/// A joint further outside its range than this is far outside, rad: published ranges are those of healthy adults by one
/// observer's way of measuring, and rigs' joints lie elsewhere.
constexpr double far_violation_angle = 10.0 * violation_angle;

/// How far a segment of ours points elsewhere than the source's in the world, rad, over the poses kept and those left
/// out because of a limit.
struct SegmentError {
    std::string segment;  ///< "trunk" (hips to shoulders), "hips" and "shoulders" (right to left), "left_thigh"...
    double mean = 0.0, max = 0.0;
};

/// Poses left out because a joint was further from rest than its limit.
struct DroppedJoint {
    std::string joint;
    int num_poses = 0;
    double max_angle = 0.0, limit = 0.0;  ///< rad
};

/// Distances of one joint of ours from where the source has it (ScaledTargets), over the frames of a clip, m.
struct JointError {
    std::string joint;
    double mean = 0.0, max = 0.0;
    double mean_before = 0.0;   ///< with the rotations alone transferred, before inverse kinematics
    double mean_uniform = 0.0;  ///< from the source's positions scaled as a whole by the ratio of leg lengths
};

/// Frames in which a joint leaves its published range.
struct LimitHits {
    std::string joint;
    int num_frames = 0;
    double max_excess = 0.0;  ///< rad
    int num_far_frames = 0;   ///< by more than far_violation_angle
};

struct RetargetReport {
    std::string clip_name, path, joint_map;
    int num_frames = 0;  ///< in the file
    double frame_rate = 0.0;
    bool frame_rate_assumed = false;
    double scale = 0.0;                   ///< metres of ours a unit of the file
    double metres_per_unit = 0.0;         ///< of the performer
    double performer_stature = 0.0;       ///< m, from the leg length
    std::string unit_from, axes_from;     ///< "file", "flag" or "estimate"
    std::string up_axis, front_axis;      ///< of the file, "+y", "-z"...
    std::string reference = "zero pose";  ///< the source's pose that stands for our rest pose

    int num_skipped = 0;                ///< at the start, because the joint map says so
    int num_glitch_frames = 0;          ///< of the file: frames next to a jump
    int num_dropped_glitches = 0;       ///< candidates at the chosen rate lost to glitches
    int num_dropped_angles = 0;         ///< candidates lost to max_joint_angle or a limit of the joint map
    int num_poses = 0;                  ///< in the result
    double mean_direction_error = 0.0;  ///< rad, between bones the map aligns, over the kept poses
    double max_joint_speed = 0.0;       ///< rad/s, fastest local joint rotation between neighbouring frames of the file

    /// Over all frames but the skipped ones, the roots aligned.
    std::vector<JointError> joint_errors;
    double mean_error = 0.0, max_error = 0.0, mean_error_before = 0.0, mean_error_uniform = 0.0;  ///< m
    double max_source_jump = 0.0, max_jump = 0.0;  ///< rad, largest jump of a joint between neighbouring frames
    int num_jumps = 0;                             ///< of our joints, all frames
    /// Jumps of a joint of ours where the source's joints that drive it and its parent do not jump against each other.
    int num_new_jumps = 0;
    double mean_iterations = 0.0;  ///< of inverse kinematics, a frame
    bool limits_checked = false, limits_clamped = false;
    int num_violating_frames = 0, num_far_frames = 0;  ///< with any joint outside its range, and far outside
    std::vector<LimitHits> limit_hits;                 ///< joints with any
    std::vector<SegmentError> segment_errors;
    std::vector<DroppedJoint> dropped_joints;

    /// The segment of the largest mean; nullptr where there is none.
    const SegmentError* worst_segment() const;
};

/// Median and worst clip of a run.
struct RetargetSummary {
    double median_error = 0.0, worst_error = 0.0;  ///< mean joint position error of a clip, m
    std::string worst_clip;
    int num_new_jumps = 0, num_frames = 0, num_violating_frames = 0, num_far_frames = 0;
    int num_checked_frames = 0;         ///< of clips whose limits were checked
    std::vector<LimitHits> limit_hits;  ///< of all clips, most frames far outside first
    SegmentError worst_segment;         ///< of the largest mean of any clip
    std::string worst_segment_clip;
};
RetargetSummary summarise(const std::vector<RetargetReport>& reports);

/// One line a clip, columns aligned, and the summary.
std::string report_table(const std::vector<RetargetReport>& reports);
/// All of it: docs/formats.md, "Motion report". Angles in degrees, lengths in millimetres where the key says so.
std::string report_json(const std::vector<RetargetReport>& reports);

}  // namespace ndg
