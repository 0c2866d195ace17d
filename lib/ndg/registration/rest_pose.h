// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/skeleton.h"
#include "ndg/body/skinning.h"
#include "ndg/core/types.h"

namespace ndg {

/// Inverse of linear blend skinning: rest positions of vertices given posed ones. Throws Error where a vertex's blended
/// motion cannot be inverted (a limb folded by 180 degrees).
Points unpose(const Eigen::Ref<const Points>& posed_vertices, const SkinningWeights& weights,
              const std::vector<Eigen::Isometry3d>& world_from_rest);

/// Joints of a skin as affine combinations of the skin around them: each joint keeps the place that it has in the
/// template among the vertices whose weights it shares with its parent (or, for joints without such a seam, its own).
class JointRegressor {
public:
    JointRegressor(const Eigen::Ref<const Points>& skin_vertices, const SkinningWeights& weights,
                   const Eigen::Ref<const Points>& joint_positions);
    /// J x 3 joints of a skin in the same tessellation and about the same pose.
    Points joints(const Eigen::Ref<const Points>& skin_vertices) const;

private:
    Points template_skin_, template_joints_;
    std::vector<std::vector<std::pair<int, double>>> rings_;  ///< of each joint: vertices and weights, summing to one
};

}  // namespace ndg
