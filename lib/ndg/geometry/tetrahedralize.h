// SPDX-License-Identifier: Apache-2.0
// Constrained Delaunay tetrahedralisation by TetGen (AGPL): only target ndg::tetgen and the tools that build templates
// link it.
#pragma once

#include "ndg/core/types.h"

namespace ndg {

struct TetrahedralMesh {
    Points vertices;        ///< the input vertices first, in their order, then the interior vertices TetGen added
    Tetrahedra tetrahedra;  ///< positive volume
};

/// Fills a closed, outward, non-self-intersecting surface; its triangles are kept as they are. `max_volume` > 0 bounds
/// the size of the tetrahedra (m^3), except at surface triangles too large for it; interior vertices are added for
/// quality where that asks for them. Deterministic.
/// Throws InputError when the surface is open, non-manifold or self-intersecting, Error when TetGen fails.
TetrahedralMesh tetrahedralize(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                               double max_volume = 0.0);

}  // namespace ndg
