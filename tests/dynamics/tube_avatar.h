// SPDX-License-Identifier: Apache-2.0
// An avatar whose skin is the tube of tests/support.
#pragma once

#include "soft_shapes.h"

#include "ndg/avatar/avatar.h"

namespace ndg::test {

/// As far as posing, measuring and simulating need it.
inline Avatar tube_avatar(const Template& tube)
{
    const SoftBody made = soft_tube(tube, 1, 1);
    const int num_wrap = tube.num_wrap_vertices();
    Avatar avatar;
    avatar.name = "tube";
    avatar.rest = made.rest;
    avatar.num_held = made.num_held;
    avatar.tetrahedra = made.tetrahedra;
    avatar.skin_triangles = made.skin_triangles;
    avatar.normals = made.normals.rowwise().normalized();
    avatar.weights = sparse_weights(tube.volume_weights(), num_standard_joints);
    avatar.skeleton = tube.skeleton;
    avatar.joint_positions = tube.rest.joint_positions;
    avatar.skin_vertices = made.rest.bottomRows(num_wrap);
    avatar.whole_skin_triangles = tube.wrap_triangles;
    for (int v = 0; v < num_wrap; ++v) avatar.volume_vertex_of_skin.push_back(2 * num_wrap + v);
    return avatar;
}

}  // namespace ndg::test
