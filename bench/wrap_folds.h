// SPDX-License-Identifier: Apache-2.0
// Where a surface is folded so far that no vertex above it sees all of its triangles from outside.
#pragma once

#include "ndg/core/types.h"

#include <algorithm>
#include <vector>

namespace ndg::bench {

/// The largest least cosine between one direction and the normals of all triangles at a vertex. Where it is not
/// positive a prism on this vertex has a corner turned inside out, wherever its upper vertex lies.
inline double visibility(const std::vector<Eigen::Vector3d>& normals)
{
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& normal : normals) direction += normal;
    if (direction.norm() < 1e-12) return -1.0;
    direction.normalize();
    double best = -1.0;
    constexpr int steps = 200;  // of a subgradient method
    for (int step = 0; step < steps; ++step) {
        const auto least = std::min_element(normals.begin(), normals.end(), [&](const auto& a, const auto& b) {
            return a.dot(direction) < b.dot(direction);
        });
        best = std::max(best, least->dot(direction));
        direction = (direction + *least / (step + 2.0)).normalized();
    }
    return best;
}

/// Vertices of a surface whose visibility is less than `least`.
inline std::vector<int> folded_vertices(const Points& vertices, const Triangles& triangles, double least = 0.02)
{
    std::vector<std::vector<Eigen::Vector3d>> normals(vertices.rows());
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        const Eigen::Vector3d a = vertices.row(triangles(t, 0)), b = vertices.row(triangles(t, 1)),
                              c = vertices.row(triangles(t, 2));
        const Eigen::Vector3d normal = (b - a).cross(c - a).normalized();
        for (int k = 0; k < 3; ++k) normals[triangles(t, k)].push_back(normal);
    }
    std::vector<int> folded;
    for (std::size_t v = 0; v < normals.size(); ++v)
        if (!normals[v].empty() && visibility(normals[v]) < least) folded.push_back(int(v));
    return folded;
}

}  // namespace ndg::bench
