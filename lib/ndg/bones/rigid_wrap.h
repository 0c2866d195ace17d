// SPDX-License-Identifier: Apache-2.0
// The bone wrap of a body whose bones are rigid.
#pragma once

#include "ndg/bones/bone_rig.h"

#include <vector>

namespace ndg {

struct RigidWrap {
    std::vector<Eigen::Isometry3d> segments;  ///< world_from_rest of the bones
    Points vertices;                          ///< N_w x 3
};

/// `body_rig`: of the body; `rest_wrap`: its bone wrap at rest, N_w x 3; `world_from_rest`: of its joints.
RigidWrap pose_rigid_wrap(const BoneRig& rig, const BodyRig& body_rig, const Eigen::Ref<const Points>& rest_wrap,
                          const std::vector<Eigen::Isometry3d>& world_from_rest);

}  // namespace ndg
