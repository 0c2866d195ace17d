// SPDX-License-Identifier: Apache-2.0
// Simple surfaces for the scene tests, and what they look like.
#pragma once

#include "ndg/scene/image.h"
#include "ndg/scene/scene_surface.h"

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace ndg::test {

/// Pixels of exactly this colour.
inline int count_pixels(const Image& image, Pixel colour)
{
    return int(std::count(image.pixels.begin(), image.pixels.end(), colour));
}

/// Square of half width `half` in the plane z = `depth`, facing +z.
inline SceneSurface square(const std::string& name, double half, double depth, const Eigen::Vector3f& colour)
{
    SceneSurface surface;
    surface.name = name;
    surface.vertices.resize(4, 3);
    surface.vertices << -half, -half, depth, half, -half, depth, half, half, depth, -half, half, depth;
    surface.triangles.resize(2, 3);
    surface.triangles << 0, 1, 2, 0, 2, 3;
    surface.colour = colour;
    return surface;
}

/// Sphere about the origin: an octahedron whose triangles are split in four `levels` times.
inline SceneSurface sphere(const std::string& name, double radius, int levels, const Eigen::Vector3f& colour)
{
    std::vector<Eigen::RowVector3d> points = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    std::vector<std::array<int, 3>> triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                                 {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    for (int level = 0; level < levels; ++level) {
        std::map<std::pair<int, int>, int> middles;
        const auto middle = [&](int a, int b) {
            const auto key = std::minmax(a, b);
            const auto [entry, inserted] = middles.emplace(key, int(points.size()));
            if (inserted) points.push_back((points[std::size_t(a)] + points[std::size_t(b)]).normalized());
            return entry->second;
        };
        std::vector<std::array<int, 3>> finer;
        for (const auto& [a, b, c] : triangles) {
            const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            finer.push_back({a, ab, ca});
            finer.push_back({ab, b, bc});
            finer.push_back({ca, bc, c});
            finer.push_back({ab, bc, ca});
        }
        triangles = finer;
    }
    SceneSurface surface;
    surface.name = name;
    surface.colour = colour;
    surface.vertices.resize(Eigen::Index(points.size()), 3);
    for (std::size_t i = 0; i < points.size(); ++i) surface.vertices.row(Eigen::Index(i)) = radius * points[i];
    surface.triangles.resize(Eigen::Index(triangles.size()), 3);
    for (std::size_t i = 0; i < triangles.size(); ++i)
        surface.triangles.row(Eigen::Index(i)) << triangles[i][0], triangles[i][1], triangles[i][2];
    return surface;
}

}  // namespace ndg::test
