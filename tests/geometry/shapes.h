// SPDX-License-Identifier: Apache-2.0
// Small closed surfaces that several geometry tests use.
#pragma once

#include "ndg/core/types.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace ndg::test {

struct Surface {
    Points vertices;
    Triangles triangles;
};

/// The unit cube [0, 1]^3 with outward triangles.
inline Surface cube()
{
    Surface surface;
    surface.vertices.resize(8, 3);
    surface.vertices << 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1;
    surface.triangles.resize(12, 3);
    surface.triangles << 0, 2, 3, 0, 3, 1,  // z = 0
        4, 5, 7, 4, 7, 6,                   // z = 1
        0, 1, 5, 0, 5, 4,                   // y = 0
        2, 6, 7, 2, 7, 3,                   // y = 1
        0, 4, 6, 0, 6, 2,                   // x = 0
        1, 3, 7, 1, 7, 5;                   // x = 1
    return surface;
}

/// Sphere of the given radius about the origin: an icosahedron, every triangle split in four `levels` times.
inline Surface icosphere(double radius, int levels)
{
    const double golden = 0.5 * (1.0 + std::sqrt(5.0));
    std::vector<Eigen::RowVector3d> vertices = {{-1, golden, 0}, {1, golden, 0}, {-1, -golden, 0}, {1, -golden, 0},
                                                {0, -1, golden}, {0, 1, golden}, {0, -1, -golden}, {0, 1, -golden},
                                                {golden, 0, -1}, {golden, 0, 1}, {-golden, 0, -1}, {-golden, 0, 1}};
    std::vector<Eigen::RowVector3i> triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                                 {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                                 {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                                 {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    for (int level = 0; level < levels; ++level) {
        std::map<std::pair<int, int>, int> middle_of;
        const auto middle = [&](int a, int b) {
            const auto key = std::make_pair(std::min(a, b), std::max(a, b));
            const auto [entry, added] = middle_of.emplace(key, static_cast<int>(vertices.size()));
            if (added) {
                const Eigen::RowVector3d sum = vertices[a] + vertices[b];
                vertices.push_back(sum);
            }
            return entry->second;
        };
        std::vector<Eigen::RowVector3i> finer;
        for (const auto& t : triangles) {
            const int ab = middle(t[0], t[1]);
            const int bc = middle(t[1], t[2]);
            const int ca = middle(t[2], t[0]);
            finer.insert(finer.end(), {{t[0], ab, ca}, {t[1], bc, ab}, {t[2], ca, bc}, {ab, bc, ca}});
        }
        triangles = std::move(finer);
        for (auto& vertex : vertices) vertex.normalize();
    }
    Surface surface;
    surface.vertices.resize(static_cast<Eigen::Index>(vertices.size()), 3);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        surface.vertices.row(static_cast<Eigen::Index>(i)) = radius * vertices[i].normalized();
    }
    surface.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        surface.triangles.row(static_cast<Eigen::Index>(i)) = triangles[i];
    }
    return surface;
}

}  // namespace ndg::test
