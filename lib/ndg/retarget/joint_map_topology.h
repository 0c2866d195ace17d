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

    double height_of(const Eigen::RowVector3d& point) const { return (point.dot(up) - ground) / height; }
};

/// See propose_joint_map. Throws InputError naming the clip.
BodyPlan find_body_plan(const MotionClip& clip, const std::vector<JointName>& names);

}  // namespace ndg
