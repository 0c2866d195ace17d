// SPDX-License-Identifier: Apache-2.0
#include "ndg/dynamics/avatar_body.h"

namespace ndg {

SoftBody soft_body_of(const Avatar& avatar, double young_normal_pascal, double young_tangent_pascal)
{
    SoftBody body;
    body.name = avatar.name;
    body.rest = avatar.rest;
    body.num_held = avatar.num_held;
    body.tetrahedra = avatar.tetrahedra;
    body.skin_triangles = avatar.skin_triangles;
    body.normals = avatar.normals;
    body.young_normal_pascal.setConstant(avatar.num_vertices(), young_normal_pascal);
    body.young_tangent_pascal.setConstant(avatar.num_vertices(), young_tangent_pascal);
    return body;
}

SoftBodyPoser poser_of(const Avatar& avatar)
{
    return {avatar.skeleton, avatar.joint_positions,
            [poser = AvatarPoser(avatar)](const Pose& pose) { return poser.world_from_unposed(pose); }};
}

}  // namespace ndg
