// SPDX-License-Identifier: Apache-2.0
// Repair and simplification of closed surfaces by CGAL (GPL): in target ndg::cgal.
#pragma once

#include "ndg/geometry/triangle_mesh.h"

namespace ndg {

/// A closed, edge- and vertex-manifold, outward surface from triangles as they come: vertices at the same place (to
/// `merge_distance`) are one, flat and doubled triangles go, vertices and edges where sheets touch are split, holes are
/// filled. Each connected component is turned outward; components that enclose nothing go, those of less than
/// `min_component_share` of the largest one's area, and those inside another one (walls of hidden cavities).
/// Deterministic.
/// Throws InputError when nothing closed is left.
TriangleMesh repair_closed(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                           double merge_distance, double min_component_share = 0.01);

/// Edge collapse (Garland and Heckbert 1997) of a closed manifold surface to about `target_vertices` (never below four
/// a component); it stays closed and manifold, since only collapses that keep the topology are made. Components
/// that this turns inside out (scraps thinner than the triangles) go; a surface that would all but vanish keeps
/// more vertices. Deterministic. Throws InputError when the surface is not closed.
TriangleMesh simplify_closed(const TriangleMesh& mesh, int target_vertices);

/// Number of edges that do not have exactly two triangles of opposite direction.
int count_open_edges(const Eigen::Ref<const Triangles>& triangles);

}  // namespace ndg
