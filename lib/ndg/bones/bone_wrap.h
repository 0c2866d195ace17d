// SPDX-License-Identifier: Apache-2.0
// Surfaces and points between bones that follow them: the bone wrap and the vertices inside it.
#pragma once

#include "ndg/bones/bone_motion.h"

#include <vector>

namespace ndg {

/// Weights of points on segments of bones, any number a point, the heaviest first; those of a point sum to one.
struct BoneWeights {
    std::vector<int> begins;    ///< N + 1: where each point's influences begin
    std::vector<int> segments;  ///< of each influence
    std::vector<double> weights;

    Eigen::Index size() const { return Eigen::Index(begins.size()) - 1; }
};

/// Of points: the distance to the nearest bone (m), and weights.
struct NearBones {
    Eigen::VectorXd distances;
    BoneWeights weights;
};
/// Bones at most `width` (m) plus once its distance farther than the nearest one have a part in a point, falling
/// smoothly with their distance: what lies at one bone follows it rigidly, what lies between bones is shared.
/// `anatomy_rest` N_a x 3, `points` N x 3, at rest. Throws Error where there are no bones.
NearBones near_bones(const BoneList& list, const Template& body_template, const Eigen::Ref<const Points>& anatomy_rest,
                     const Eigen::Ref<const Points>& points, double width = 0.012);

/// Weights of the vertices of a surface spread over it by about `spread` (m, standard deviation), so that the surface
/// between bones bends over a length and not at an edge. `vertices` N x 3 at rest.
BoneWeights smoothed_weights(const BoneWeights& weights, const Eigen::Ref<const Points>& vertices,
                             const Eigen::Ref<const Triangles>& triangles, double spread = 0.060);

/// Dual quaternion blending of rigid motions (Kavan et al. 2007), N x 3: no collapse where bones turn against each
/// other.
Points dual_quaternion_blending(const Eigen::Ref<const Points>& rest, const BoneWeights& weights,
                                const std::vector<Eigen::Isometry3d>& motions);

}  // namespace ndg
