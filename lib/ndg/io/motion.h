// SPDX-License-Identifier: Apache-2.0
// Motion-capture files as they are: their own skeleton, unit and joint names.
#pragma once

#include "ndg/core/types.h"

#include <string>
#include <vector>

namespace ndg {

class SmplSkeleton;

/// A skeleton and its frames, in the file's unit and axes, after all file conventions (Euler orders, axis frames,
/// degrees) are resolved: every joint has, at the file's zero pose, a frame aligned with the file's world axes.
struct MotionClip {
    std::string name;                      ///< file name without folder and extension
    std::vector<std::string> joint_names;  ///< J; the root first
    std::vector<int> parents;              ///< J; parent before child, -1 for the root
    Points zero_pose_positions;            ///< J x 3, joint positions at the zero pose, root at origin
    Points zero_pose_tips;                 ///< J x 3, end of each joint's bone at the zero pose
    double frame_rate = 0.0;               ///< frames a second
    bool frame_rate_assumed = false;       ///< true where the file does not store it (most AMC: 120)
    std::vector<std::vector<Eigen::Matrix3d>> world_from_joint;  ///< frames x J rotations; identity at the zero pose
    Points root_positions;                                       ///< frames x 3
    double metres_per_unit = 0.0;                                ///< from the file (ASF); 0 where the file does not say
    bool axes_known = false;  ///< the format says that the zero pose stands along +y and faces +z

    int num_joints() const { return static_cast<int>(joint_names.size()); }
    int num_frames() const { return static_cast<int>(world_from_joint.size()); }
    /// Index of a joint, -1 where there is none of that name.
    int find_joint(const std::string& joint_name) const;
    /// J x 3 positions of all joints in a frame, in the file's unit and axes.
    Points joint_positions(int frame_idx) const;
};

/// Turns zero pose, rotations and root positions of a clip by the rotation `turn`.
void turn_clip(MotionClip& clip, const Eigen::Matrix3d& turn);

/// Biovision hierarchy. Euler order from CHANNELS. Joint frame semantics: see MotionClip. The tip of a joint is its End
/// Site, or the mean of its children's positions. Position channels of the root replace its OFFSET; those of other
/// joints (which some writers add) are read over, because bone lengths are fixed here.
/// Throws InputError naming file, line and value: unknown keyword, wrong number of channel values, no frames,
/// fewer or more frames than announced, non-finite.
MotionClip read_bvh(const std::string& path);

/// Acclaim skeleton and motion. A bone of the file is a joint here: its position is the bone's start, its tip the
/// bone's end; the local rotation is C Rz Ry Rx C^-1 with C the bone's axis frame (axis order XYZ; others likewise).
/// The frame rate is that of :SAMPLES-PER-SECOND in the AMC; without it 120 Hz is assumed. Throws InputError as
/// read_bvh does.
MotionClip read_asf_amc(const std::string& asf_path, const std::string& amc_path);

/// DeepMimic: a character's skeleton (JSON, metres) and a clip of it (JSON text; a row is a duration, the root's
/// position and quaternion wxyz, then four or one values a joint). The files face +x and are turned here to face +z.
/// The frame rate is that of the median duration. Throws InputError naming file, item and value: not JSON, unknown
/// joint type, row of another length, non-finite value, quaternion far from norm 1, no frames.
MotionClip read_deepmimic(const std::string& character_path, const std::string& motion_path);

/// AMASS: axis-angles of the 22 body joints, and of the 30 of the hands where the file has them (SMPL-H and SMPL-X:
/// "poses" of 156 or 165 columns, or "root_orient", "pose_body" and "pose_hand"), z up, turned here to y up. Jaw and
/// eyes are not read. The zero pose is the T pose of `model` with the file's "betas", as far as the model has them,
/// and root positions are those of its pelvis; without a model a T pose of straight limbs and common proportions, and
/// the root's position is "trans", which differs from the pelvis by a constant of the body's shape. Throws InputError
/// naming file, item and value as NpzFile does, and for another shape and no frames.
MotionClip read_amass(const std::string& path, const SmplSkeleton* model = nullptr);
/// Whether an .npz holds poses and a path (AMASS has others, of shapes). Throws InputError where it is no archive.
bool is_amass(const std::string& path);

}  // namespace ndg
