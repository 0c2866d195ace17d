// SPDX-License-Identifier: Apache-2.0
// The body plan of an unknown skeleton: where its legs, arms, spine and head are.
#pragma once

#include "ndg/io/motion.h"
#include "ndg/retarget/joint_map_names.h"

#include <array>
#include <vector>

namespace ndg {

struct BodyPlan {
    Eigen::Vector3d left, up, front;             ///< unit axes of the file
    double ground = 0.0, height = 0.0;           ///< lowest point along `up` and extent, the file's unit
    std::array<std::vector<int>, 2> legs, arms;  ///< left and right: joints from the trunk to the farthest leaf
    std::vector<int> spine;  ///< from the joint that both legs hang on to the one that both arms hang on, both included
    std::vector<int> head;   ///< from above the latter upwards, as far as the head
    bool sides_from_names = false;
    /// Lengths along the bones from where the limbs part to each joint of `legs` and `arms`, as a share of stature
    /// (that of whose legs' bones are as long): known whatever the pose.
    std::array<std::vector<double>, 2> leg_shares, arm_shares;

    double height_of(const Eigen::RowVector3d& point) const { return (point.dot(up) - ground) / height; }
};

/// See propose_joint_map. `by_lengths`: the zero pose is no standing person, so that mirror images without names are
/// found by the lengths of bones and what hangs on them; axes, ground and height mean nothing then. Throws InputError
/// naming the clip.
BodyPlan find_body_plan(const MotionClip& clip, const std::vector<JointName>& names, bool by_lengths = false);

}  // namespace ndg
