// SPDX-License-Identifier: Apache-2.0
#include "ndg/bones/rigid_wrap.h"

namespace ndg {

RigidWrap pose_rigid_wrap(const BoneRig& rig, const BodyRig& body_rig, const Eigen::Ref<const Points>& rest_wrap,
                          const std::vector<Eigen::Isometry3d>& world_from_rest)
{
    RigidWrap wrap;
    wrap.segments = body_rig.motion.segments(world_from_rest);
    wrap.vertices = dual_quaternion_blending(rest_wrap, rig.wrap_weights, wrap.segments);
    body_rig.clearance.push_out(wrap.segments, wrap.vertices);
    return wrap;
}

}  // namespace ndg
