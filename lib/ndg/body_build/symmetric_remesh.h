// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"

#include <string>
#include <vector>

namespace ndg {

/// Regions of the skin. The volumetric region is `body`; the others stay surfaces moved by linear blend skinning.
extern const std::vector<std::string> skin_region_names;  // body, head, left_hand, right_hand, left_toes, right_toes

struct RemeshedSkin {
    Points vertices;           ///< on the input surface
    Triangles triangles;       ///< closed, outward, mirror image of itself in x = 0
    std::vector<int> regions;  ///< T, indices into skin_region_names
    std::vector<int> mirror;   ///< N, vertex at the mirrored place (itself on x = 0)
};

/// Isotropic remeshing of a (nearly) symmetric closed surface: one half is remeshed, cut at x = 0, and mirrored. Edges
/// of about `target_edge_length` in the body region, `keep_ratio` of the source's triangles elsewhere; the borders of
/// the regions are smooth chains of edges that lie on the cutting planes (region_cut.h). `weights`: N x J dense.
/// Throws InputError when the surface is too far from symmetric, with the distance. Deterministic.
RemeshedSkin remesh_symmetric(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                              const Eigen::Ref<const RowMatrix>& weights,
                              const Eigen::Ref<const Points>& joint_positions, double target_edge_length,
                              double keep_ratio);

}  // namespace ndg
