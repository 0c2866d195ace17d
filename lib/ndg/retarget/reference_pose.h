// SPDX-License-Identifier: Apache-2.0
// The pose of a source that stands for our rest pose: its zero pose where that is a standing person, else a frame.
#pragma once

#include "ndg/core/axis.h"
#include "ndg/retarget/joint_map.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace ndg {

/// Joints of a clip that show how it stands: left, right; -1 where the map drives none.
struct StanceJoints {
    std::array<int, 2> hips{}, knees{}, ankles{}, toes{}, shoulders{}, elbows{}, wrists{};
    int head = -1;
};
StanceJoints stance_joints(const MotionClip& clip, const JointMap& map);

/// How a pose differs from a person who stands straight with the arms anywhere beside the body.
struct Stance {
    /// Each angle over its allowance (knee 35 degrees, hip 45, hips across the trunk 25, shoulders against hips 40,
    /// elbow 75, head against trunk 50; one ankle above the other, seen from the hips, 8; the pitch of one foot against
    /// the other 25): the largest, and the root mean square. Angles without joints count as none.
    double largest = 0.0, mean = 0.0;
    /// Unit vectors of the file: from hips to shoulders (or head), from right to left hip and shoulder; the hips' where
    /// there are no shoulders.
    Eigen::Vector3d trunk, hips_left, shoulders_left;

    bool stands() const { return largest <= 1.0; }
};
Stance stance_of(const StanceJoints& joints, const Points& positions);

/// What --reference-frame may be besides a frame.
inline constexpr int find_reference_frame = -1, zero_pose_is_reference = -2, straightest_frame = -3;

struct ReferencePose {
    int frame_idx = zero_pose_is_reference;
    bool stands = false;  ///< Stance::stands
    /// Of the file, along a coordinate axis: that of the zero pose where it is the reference and stands along the axis
    /// that the frames stand along; else the frames'.
    Eigen::Vector3d up = Eigen::Vector3d::UnitY();
    bool zero_pose_lies = false;  ///< the zero pose is the reference, but along another axis than `up`
    /// The zero pose stands along +y and the frames along another axis: either could be up; `up` is +y.
    bool up_is_doubtful = false;
};

/// `frame_idx`: a frame, zero_pose_is_reference, straightest_frame (of up to 1000 evenly spaced ones the one that
/// stands straightest along the axis most of them stand along), or find_reference_frame: the zero pose where it stands,
/// else the straightest frame, where that is nearer to standing than the zero pose. `up`: of the file; none: found.
/// Throws InputError naming the clip for a frame it does not have.
ReferencePose find_reference_pose(const MotionClip& clip, const StanceJoints& joints, int frame_idx,
                                  const std::optional<Axis>& up);

/// Makes the pose in which joint j has the world rotation world_from_joint[j] the zero pose of the clip. Positions in
/// frames stay as they are.
void set_zero_pose(MotionClip& clip, const std::vector<Eigen::Matrix3d>& world_from_joint);

/// Rotations of `frame_idx` of `other`, a clip of the same rig, in the order of `clip`'s joints. Throws InputError
/// naming clip and joint where it lacks one or a bone differs at the zero pose by more than 2 % of the clip's size.
std::vector<Eigen::Matrix3d> reference_rotations(const MotionClip& clip, const MotionClip& other, int frame_idx);

/// For a clip that is y up: brings a zero pose that leans, twists or faces elsewhere upright and to +z, in that each
/// joint's frame turns: pelvis and lower trunk so that the trunk is upright and the hips lie along x, what hangs on the
/// shoulders likewise by these, the legs about the vertical alone (their bones keep their lean). Where the zero pose
/// `stands`, it is turned as a whole, by no less than 3 degrees about the vertical or 12 degrees else: below lie rigs'
/// own asymmetries. Returns the angle by which the pelvis was turned, rad.
double straighten_zero_pose(MotionClip& clip, const StanceJoints& joints, bool stands);

}  // namespace ndg
