// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"

#include <vector>

namespace ndg {

/// Mean distance of the skin from the limb's axis (elbow, wrist, knee, ankle and ball of the foot divide it), at every
/// vertex, m: local along the limb, blended by the weights, less on the foot, whose heel is rounder; `trunk_radius` off
/// the limbs. `weights`: N x J dense.
Eigen::VectorXd limb_radius(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const RowMatrix>& weights,
                            const Eigen::Ref<const Points>& joint_positions, double trunk_radius);

/// For every vertex, the length of the shortest way along edges to one of `starts`, and which one that is (-1: none).
struct EdgeDistance {
    Eigen::VectorXd distance;
    std::vector<int> nearest;
};
EdgeDistance distance_along_edges(const Eigen::Ref<const Points>& vertices,
                                  const Eigen::Ref<const Triangles>& triangles, const std::vector<int>& starts);

/// Mean length of the edges at each vertex, m.
Eigen::VectorXd mean_edge_length(const Eigen::Ref<const Points>& vertices,
                                 const Eigen::Ref<const Triangles>& triangles);

}  // namespace ndg
