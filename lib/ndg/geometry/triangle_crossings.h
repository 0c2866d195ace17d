// SPDX-License-Identifier: Apache-2.0
// Where a surface passes through itself or another. In plain double precision and without CGAL, which intersections.h
// needs.
#pragma once

#include "ndg/core/types.h"

#include <utility>
#include <vector>

namespace ndg {

/// Whether the segment passes through the inside of the triangle, to rounding; touching does not count.
bool segment_crosses_triangle(const Eigen::Vector3d& begin, const Eigen::Vector3d& end, const Eigen::Vector3d& a,
                              const Eigen::Vector3d& b, const Eigen::Vector3d& c);

/// Pairs of triangles, the smaller index first, ascending, of which an edge of one crosses the other. Neighbours with
/// one common vertex count where they meet elsewhere too, those with a common edge do not.
std::vector<std::pair<int, int>> crossing_triangles(const Eigen::Ref<const Points>& vertices,
                                                    const Eigen::Ref<const Triangles>& triangles);

/// Pairs (triangle of the first surface, triangle of the second), ascending, of which an edge of one crosses the other.
std::vector<std::pair<int, int>> crossing_triangles(const Eigen::Ref<const Points>& first_vertices,
                                                    const Eigen::Ref<const Triangles>& first_triangles,
                                                    const Eigen::Ref<const Points>& second_vertices,
                                                    const Eigen::Ref<const Triangles>& second_triangles);

/// The triangles that take part, ascending.
std::vector<int> triangles_of_pairs(const std::vector<std::pair<int, int>>& pairs);

}  // namespace ndg
