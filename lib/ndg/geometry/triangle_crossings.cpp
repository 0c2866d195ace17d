// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/triangle_crossings.h"

#include "ndg/geometry/box_pairs.h"

#include <algorithm>

namespace ndg {

namespace {

double orientation(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                   const Eigen::Vector3d& d)
{
    return (b - a).cross(c - a).dot(d - a);
}

bool has_vertex(const Eigen::Ref<const Triangles>& triangles, int t, int vertex)
{
    return (triangles.row(t).array() == vertex).any();
}

/// Whether an edge of s that shares no vertex with t crosses t.
bool edge_crosses(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles, int s, int t)
{
    const auto position = [&](int v) -> Eigen::Vector3d { return vertices.row(v).transpose(); };
    for (int i = 0; i < 3; ++i) {
        const int begin = triangles(s, i), end = triangles(s, (i + 1) % 3);
        if (has_vertex(triangles, t, begin) || has_vertex(triangles, t, end)) continue;
        if (segment_crosses_triangle(position(begin), position(end), position(triangles(t, 0)),
                                     position(triangles(t, 1)), position(triangles(t, 2)))) {
            return true;
        }
    }
    return false;
}

/// Whether an edge of triangle s of one surface crosses triangle t of another.
bool edge_crosses(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles, int s,
                  const Eigen::Ref<const Points>& other_vertices, const Eigen::Ref<const Triangles>& other_triangles,
                  int t)
{
    for (int i = 0; i < 3; ++i) {
        if (segment_crosses_triangle(vertices.row(triangles(s, i)), vertices.row(triangles(s, (i + 1) % 3)),
                                     other_vertices.row(other_triangles(t, 0)),
                                     other_vertices.row(other_triangles(t, 1)),
                                     other_vertices.row(other_triangles(t, 2)))) {
            return true;
        }
    }
    return false;
}

}  // namespace

bool segment_crosses_triangle(const Eigen::Vector3d& begin, const Eigen::Vector3d& end, const Eigen::Vector3d& a,
                              const Eigen::Vector3d& b, const Eigen::Vector3d& c)
{
    const double side_begin = orientation(a, b, c, begin), side_end = orientation(a, b, c, end);
    if (side_begin * side_end >= 0) return false;
    const double ab = orientation(begin, end, a, b), bc = orientation(begin, end, b, c),
                 ca = orientation(begin, end, c, a);
    return (ab > 0 && bc > 0 && ca > 0) || (ab < 0 && bc < 0 && ca < 0);
}

std::vector<std::pair<int, int>> crossing_triangles(const Eigen::Ref<const Points>& vertices,
                                                    const Eigen::Ref<const Triangles>& triangles)
{
    const Boxes boxes = bounding_boxes(vertices, triangles);
    std::vector<std::pair<int, int>> pairs;
    for (const auto& [s, t] : overlapping_boxes(boxes, boxes)) {
        if (s < t && (edge_crosses(vertices, triangles, s, t) || edge_crosses(vertices, triangles, t, s))) {
            pairs.emplace_back(s, t);
        }
    }
    return pairs;
}

std::vector<std::pair<int, int>> crossing_triangles(const Eigen::Ref<const Points>& first_vertices,
                                                    const Eigen::Ref<const Triangles>& first_triangles,
                                                    const Eigen::Ref<const Points>& second_vertices,
                                                    const Eigen::Ref<const Triangles>& second_triangles)
{
    std::vector<std::pair<int, int>> pairs;
    for (const auto& [s, t] : overlapping_boxes(bounding_boxes(first_vertices, first_triangles),
                                                bounding_boxes(second_vertices, second_triangles))) {
        if (edge_crosses(first_vertices, first_triangles, s, second_vertices, second_triangles, t) ||
            edge_crosses(second_vertices, second_triangles, t, first_vertices, first_triangles, s)) {
            pairs.emplace_back(s, t);
        }
    }
    return pairs;
}

std::vector<int> triangles_of_pairs(const std::vector<std::pair<int, int>>& pairs)
{
    std::vector<int> triangles;
    for (const auto& [s, t] : pairs) triangles.insert(triangles.end(), {s, t});
    std::sort(triangles.begin(), triangles.end());
    triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
    return triangles;
}

}  // namespace ndg
