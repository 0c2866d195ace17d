// SPDX-License-Identifier: Apache-2.0
// World rotations of a source skeleton on ours: the start, and the reference, of inverse kinematics.
#pragma once

#include "ndg/body/skeleton.h"
#include "ndg/retarget/joint_map.h"

#include <array>
#include <vector>

namespace ndg {

/// A joint map resolved to indices of one clip, and the alignment of the rest poses. For joint j with source rotation
/// R_src (blended where the map says so) the world rotation is R_src A_j, where A_j takes our rest bone (A pose) to the
/// source's bone at its zero pose, built down the chain by minimal rotations from the parent's alignment, so that bones
/// point as in the source without arbitrary twist; unmapped joints follow their parent. Where the source's elbow is a
/// hinge, the upper arm's A_j is turned about itself until our elbow bends about its own axis. Where the source's bone
/// has a joint within (a limb of two bones), the rotation is completed by the least one that brings our bone onto the
/// line between its ends. A twist that is shared (pronation) is followed through the clip past half a turn, so that its
/// share does not jump; whole turns are counted so that most frames have less than half of one.
class RotationTransfer {
public:
    /// How one of our joints follows the clip.
    struct Link {
        int source = -1, blend_with = -1;  ///< joints of the clip, -1: none
        double fraction = 0.0;
        bool twist_only = false;
        Eigen::Vector3d source_bone = Eigen::Vector3d::Zero();  ///< zero pose; zero where not aligned
        Eigen::Vector3d our_bone = Eigen::Vector3d::Zero();     ///< rest pose
        int toward = -1, bone_from = -1, bone_to = -1;          ///< ends of the bones: ours, the source's (-1: a tip)
        bool bone_bends = false;                                ///< the source has a joint between the ends of its bone
        double limit = 2.0 * M_PI;                              ///< rad from rest
        bool sole = false;
        Eigen::Vector3d source_up = Eigen::Vector3d::UnitY();

        bool aligned() const { return !source_bone.isZero(0.0); }
    };

    /// `joint_positions`: J x 3 rest positions of the body. Throws InputError naming clip and item: map that does not
    /// fit, bone or legs of zero length. The clip must outlive this.
    RotationTransfer(const MotionClip& clip, const JointMap& map, const Eigen::Ref<const Points>& joint_positions);

    const MotionClip& clip() const { return clip_; }
    const std::vector<Link>& links() const { return links_; }  ///< one a joint of ours
    const std::vector<Eigen::Matrix3d>& alignment() const { return alignment_; }
    /// Our leg length (hip, knee, ankle) over the source's, metres a unit of the file.
    double scale() const { return scale_; }
    /// Length of the source's legs at the zero pose, in its unit.
    double source_leg_length() const { return source_leg_length_; }

    /// World rotations of our joints in a frame, J.
    std::vector<Eigen::Matrix3d> world_rotations(int frame_idx) const;
    /// Rotation of joint j's source (blended) in a frame; its parent's where it has none. Identity at the zero pose.
    Eigen::Matrix3d source_rotation(int joint, int frame_idx) const;
    /// Where the root joint goes: the midpoint of the hips follows the source's, scaled, from above the origin at
    /// `first_frame`. `pelvis`: world rotation of our root joint.
    Eigen::Vector3d root_translation(int frame_idx, int first_frame, const Eigen::Matrix3d& pelvis) const;
    /// Midpoint of the source's hips, given its joints in a frame, in the file's unit.
    Eigen::Vector3d source_hips(const Points& source_positions) const;
    /// Midpoint of our hips at rest, from the root joint.
    const Eigen::Vector3d& hips_from_root() const { return hips_from_root_; }

private:
    const MotionClip& clip_;
    std::vector<Link> links_;
    std::vector<Eigen::Matrix3d> alignment_;
    std::vector<Eigen::Vector3d> twist_axes_;
    std::vector<std::vector<double>> twist_angles_;  ///< one list of frames a joint; empty where it shares no twist
    std::array<int, 2> source_hip_joints_{};
    bool has_bending_bones_ = false;
    Eigen::Vector3d hips_from_root_, root_rest_;
    double scale_ = 1.0, source_leg_length_ = 0.0;
};

/// Local rotations of our skeleton from world rotations, brought back onto the rotations.
std::vector<Eigen::Matrix3d> local_rotations(const std::vector<Eigen::Matrix3d>& world_from_joint);
/// World rotations from local ones.
std::vector<Eigen::Matrix3d> compose_rotations(const std::vector<Eigen::Matrix3d>& parent_from_joint);

}  // namespace ndg
