// SPDX-License-Identifier: Apache-2.0
// Bone wrap and muscle wrap by the inner-surface construction of Romero et al. 2020, section 3.2.
#pragma once

#include "ndg/core/types.h"

#include <string>
#include <vector>

namespace ndg {

/// The volumetric skin of one body and what the construction needs to know about it.
struct WrapSkin {
    Points vertices;         ///< N_w x 3
    Triangles triangles;     ///< T_w x 3, outward
    RowMatrix weights;       ///< N_w x J, dense
    Points joint_positions;  ///< J x 3
};

/// Every skin vertex projected to the nearest bone it hangs on, the projections smoothed along the surface while they
/// slide along the skeleton. N_w x 3.
Points skeleton_projection(const WrapSkin& skin);

/// Share of the way from skin to skeleton that is soft tissue (fat and muscle), for each vertex: large where the bone
/// is thin against the limb, small at the rib cage. N_w, blended by the skinning weights and smoothed.
Eigen::VectorXd soft_tissue_share(const WrapSkin& skin);

/// Inner wraps whose prisms are all valid.
struct Wraps {
    Points bone;                       ///< N_w x 3
    Points muscle;                     ///< N_w x 3
    int adjusted_vertices = 0;         ///< moved off their intended place to keep prisms valid
    double min_scaled_jacobian = 0.0;  ///< over both layers
};

/// Bone wrap at `intended_bone`, muscle wrap at the share `fat_share` (N_w, of the way from skin to bone wrap), both
/// moved where a prism would be invalid or flatter than `min_scaled_jacobian`: offsets of the vertices concerned are
/// smoothed and shortened until it holds. Throws Error naming `body_name` and the worst prism when no valid state is
/// found.
Wraps valid_wraps(const WrapSkin& skin, const Eigen::Ref<const Points>& intended_bone, const Eigen::VectorXd& fat_share,
                  double min_scaled_jacobian, const std::string& body_name);

}  // namespace ndg
