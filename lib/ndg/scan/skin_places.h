// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/skinning.h"
#include "ndg/core/types.h"

#include <string>
#include <vector>

namespace ndg {

/// A skin at rest with what moves it.
struct SkinnedSurface {
    Points vertices;          ///< N x 3, closed, y up, facing +z
    Triangles triangles;      ///< T x 3
    SkinningWeights weights;  ///< N rows on the standard skeleton
    Points joint_positions;   ///< J x 3
};

/// Sum of a vertex's weights for the named joints and all joints below them, N values in [0, 1].
Eigen::VectorXd subtree_weights(const SkinningWeights& weights, const std::vector<std::string>& joint_names);

/// Places that scanners do not see and that registration treats with care, found by skinning weights and normals.
struct SkinPlaces {
    Eigen::Vector3d left_armpit, right_armpit;  ///< middle of the fold's underside
    Eigen::Vector3d crotch;
    std::vector<int> sole_vertices;  ///< of both feet
    double head_top = 0.0;           ///< height of the highest point, m
};
/// Throws Error when a place has no vertex (no skin in the standard skeleton's rest pose).
SkinPlaces find_skin_places(const SkinnedSurface& skin);

}  // namespace ndg
