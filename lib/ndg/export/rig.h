// SPDX-License-Identifier: Apache-2.0
// A mesh on a skeleton, as engines and animation programs move it: linear blend skinning, and morphs before it.
#pragma once

#include "ndg/core/types.h"

#include <Eigen/Geometry>

#include <string>
#include <vector>

namespace ndg {

/// At rest, joint frames are aligned with the world.
struct Rig {
    int mesh_idx = 0;                      ///< which mesh of the sequence it moves; that one's frames are not written
    Points rest_vertices;                  ///< N x 3, m
    std::vector<std::string> joint_names;  ///< J, unlike each other
    std::vector<int> parents;              ///< parent before child; -1 for the root, joint 0
    Points joint_positions;                ///< J x 3, at rest
    RowMatrixI weight_joints;              ///< N x 4 or N x 8
    RowMatrix weights;                     ///< of them, rows sum to one; unused slots hold joint 0 with weight 0
    std::vector<std::vector<Eigen::Quaterniond>> rotations;  ///< frame, joint: from joint to parent (root: to world)
    Points root_translations;                                ///< frames x 3, displacement of the root joint
    std::vector<Points> morphs;                              ///< K, N x 3: offsets at rest
    RowMatrix morph_weights;                                 ///< frames x K

    int num_joints() const { return int(joint_names.size()); }
    /// Of a joint, from its parent joint; of the root from the origin.
    Eigen::RowVector3d local_position(int joint) const
    {
        Eigen::RowVector3d position = joint_positions.row(joint);
        if (parents[joint] >= 0) position -= joint_positions.row(parents[joint]);
        return position;
    }
};

/// Successive frames that belong together.
struct RigClip {
    std::string name;
    int frame_begin = 0, frame_end = 0;
    double frame_rate = 30.0;  ///< Hz

    int size() const { return frame_end - frame_begin; }
};

}  // namespace ndg
