// SPDX-License-Identifier: Apache-2.0
// Captures of a tube.
#pragma once

#include "../dynamics/tube_avatar.h"

#include "ndg/capture/capture.h"

namespace ndg::test {

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
