// SPDX-License-Identifier: Apache-2.0
// Intersections of triangle meshes by CGAL (GPL): only target ndg::cgal and the tools that build templates link it.
#pragma once

#include "ndg/core/types.h"

#include <utility>
#include <vector>

namespace ndg {

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
