// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/skeleton.h"
#include "ndg/body/skinning.h"
#include "ndg/core/types.h"

#include <utility>
#include <vector>

namespace ndg {

/// Inverse of linear blend skinning: rest positions of vertices given posed ones. Throws Error where a vertex's blended
/// motion cannot be inverted (a limb folded by 180 degrees).
Points unpose(const Eigen::Ref<const Points>& posed_vertices, const SkinningWeights& weights,
              const std::vector<Eigen::Isometry3d>& world_from_rest);

/// A skin in the template's tessellation and pose whose joints are known.
struct JointExample {
    Points skin_vertices;    ///< N x 3
    Points joint_positions;  ///< J x 3
};

/// Joints of a skin at rest as combinations of the skin around them, with coefficients that sum to one.
class JointRegressor {
public:
    /// Coefficients from examples (joint regression as in SMPL, Loper et al. 2015): ridge regression over the template
    /// and skins in its tessellation with known joints. Without examples the template is the only one and every joint
    /// keeps its place in the skin around it.
    JointRegressor(const Eigen::Ref<const Points>& skin_vertices, const SkinningWeights& weights,
                   const Eigen::Ref<const Points>& joint_positions, const std::vector<JointExample>& examples = {});
    /// J x 3 joints of a skin in the same tessellation.
    Points joints(const Eigen::Ref<const Points>& skin_vertices) const;

private:
    std::vector<std::vector<std::pair<int, double>>> combinations_;  ///< of each joint: vertices and coefficients
};

}  // namespace ndg
