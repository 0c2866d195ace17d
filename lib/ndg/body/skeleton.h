// SPDX-License-Identifier: Apache-2.0
// The skeleton of 60 joints and its poses. At rest every joint frame is aligned with the world axes.
#pragma once

#include "ndg/core/types.h"

#include <string>
#include <vector>

namespace ndg {

/// Names and hierarchy; joint positions belong to a body.
struct Skeleton {
    std::vector<std::string> joint_names;
    std::vector<int> parents;  ///< parent before child; -1 for the root (joint 0)

    int num_joints() const { return static_cast<int>(joint_names.size()); }
    /// Index of a joint; throws Error when there is none of that name.
    int joint(const std::string& name) const;
};

/// The project's skeleton: pelvis, spine_1..5, neck_1..2, head, jaw, left_eye, right_eye (12), and for each side
/// clavicle, upper_arm, forearm, forearm_twist, hand, {thumb,index,middle,ring,pinky}_1..3 (20), thigh, shin, foot,
/// toes (4), named left_* and right_*.
const Skeleton& standard_skeleton();
constexpr int num_standard_joints = 60;

/// A pose: local rotations (from joint frame to parent frame; the root's to world) and where the root goes.
struct Pose {
    std::vector<Eigen::Matrix3d> parent_from_joint;              ///< J rotations, identity at rest
    Eigen::Vector3d root_translation = Eigen::Vector3d::Zero();  ///< world displacement of the root joint, m

    static Pose rest(int num_joints);
};

/// Rigid motion of each joint's surroundings from rest to posed world: x_posed = world_from_rest[j] * x_rest.
/// `joint_positions`: J x 3 rest positions of the body.
std::vector<Eigen::Isometry3d> forward_kinematics(const Skeleton& skeleton,
                                                  const Eigen::Ref<const Points>& joint_positions, const Pose& pose);

}  // namespace ndg
