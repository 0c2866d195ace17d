// SPDX-License-Identifier: Apache-2.0
// Isotropic remeshing and decimation by CGAL (GPL): only target ndg::remesh and the tools that build templates link it.
#pragma once

#include "ndg/core/types.h"

#include <vector>

namespace ndg {

struct TriangleMesh {
    Points vertices;
    Triangles triangles;
};

/// Remeshes the triangles whose label is > 0 to edges of about `target_edge_length` (metres), one label region at a
/// time so that the borders between labels stay chains of edges; triangles of label 0 are decimated by edge collapse
/// (Garland-Heckbert) to about `keep_ratio` of their number. Vertices of labelled regions and borders lie on the input
/// surface. A single triangle that sticks out of its region like a tooth first takes the label around it. Returns the
/// new mesh and, per triangle, its label. Deterministic.
/// Closed, manifold input gives closed, manifold output. Throws InputError otherwise.
struct RemeshResult {
    TriangleMesh mesh;
    std::vector<int> triangle_labels;
};
RemeshResult remesh_regions(const TriangleMesh& mesh, const std::vector<int>& triangle_labels,
                            double target_edge_length, double keep_ratio);

/// Pairs of intersecting triangles, by CGAL's exact predicates: those without a common vertex, or also
/// `with_neighbours` that share a vertex and meet elsewhere too, or share an edge and lie on each other.
std::vector<std::pair<int, int>> self_intersections(const Eigen::Ref<const Points>& vertices,
                                                    const Eigen::Ref<const Triangles>& triangles,
                                                    bool with_neighbours = false);

/// Pairs (triangle of the first surface, triangle of the second) that intersect or touch, by CGAL's exact predicates.
std::vector<std::pair<int, int>> surface_intersections(const Eigen::Ref<const Points>& first_vertices,
                                                       const Eigen::Ref<const Triangles>& first_triangles,
                                                       const Eigen::Ref<const Points>& second_vertices,
                                                       const Eigen::Ref<const Triangles>& second_triangles);

}  // namespace ndg
