// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body_source/template_source.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace ndg::test {

/// A capsule around the segment from (0, -half, 0) to (0, half, 0), outward; a ball for half = 0.
inline AnatomyMesh capsule(const std::string& name, const std::string& layer, double radius, double half,
                           const Eigen::RowVector3d& centre, int rings = 30, int segments = 36)
{
    AnatomyMesh part;
    part.name = name;
    if (!layer.empty()) part.layer = parse_name<AnatomyLayer>(layer);
    part.vertices.resize(rings * segments + 2, 3);
    for (int r = 0; r < rings; ++r)
        for (int s = 0; s < segments; ++s) {
            const double polar = M_PI * (r + 1) / (rings + 1), around = 2 * M_PI * s / segments;
            const double lift = half * std::clamp(std::cos(polar) * 2.0, -1.0, 1.0);
            part.vertices.row(r * segments + s) =
                centre + Eigen::RowVector3d(radius * std::sin(polar) * std::cos(around),
                                            radius * std::cos(polar) + lift,
                                            -radius * std::sin(polar) * std::sin(around));
        }
    const int top = rings * segments, bottom = top + 1;
    part.vertices.row(top) = centre + Eigen::RowVector3d(0, radius + half, 0);
    part.vertices.row(bottom) = centre - Eigen::RowVector3d(0, radius + half, 0);
    part.triangles.resize(2 * rings * segments, 3);
    Eigen::Index t = 0;
    for (int s = 0; s < segments; ++s) {
        const int next = (s + 1) % segments, last = (rings - 1) * segments;
        part.triangles.row(t++) << top, s, next;
        part.triangles.row(t++) << bottom, last + next, last + s;
        for (int r = 0; r + 1 < rings; ++r) {
            const int a = r * segments + s, b = r * segments + next, c = a + segments, d = b + segments;
            part.triangles.row(t++) << a, c, b;
            part.triangles.row(t++) << b, c, d;
        }
    }
    return part;
}

}  // namespace ndg::test
