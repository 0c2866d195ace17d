// SPDX-License-Identifier: Apache-2.0
// An avatar whose skin is the tube of tests/support, and captures of it.
#pragma once

#include "../dynamics/soft_shapes.h"

#include "ndg/avatar/avatar.h"
#include "ndg/capture/capture.h"

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

/// The tube's skin as skinning moves it, at 60 Hz.
inline CaptureSequence skinned_tube(const Avatar& avatar, int num_frames)
{
    CaptureSequence sequence;
    sequence.name = "swing";
    const AvatarPoser poser(avatar);
    for (int f = 0; f < num_frames; ++f) {
        Pose pose = tube_pose(0.8 * std::sin(0.3 * f));
        pose.root_translation = Eigen::Vector3d(0.1 * f, 0.02 * f * f, -0.05 * f);
        sequence.frame_numbers.push_back(f);
        sequence.poses.push_back(pose);
        sequence.vertices.push_back(
            to_world(poser.world_from_unposed(pose), avatar.rest).bottomRows(avatar.skin_vertices.rows()));
    }
    return sequence;
}

inline Capture tube_capture(const Avatar& avatar, int num_frames)
{
    Capture capture;
    capture.subject = avatar.name;
    capture.triangles = avatar.whole_skin_triangles;
    capture.joint_names = avatar.skeleton.joint_names;
    capture.sequences = {skinned_tube(avatar, num_frames)};
    return capture;
}

}  // namespace ndg::test
