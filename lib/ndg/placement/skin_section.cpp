// SPDX-License-Identifier: Apache-2.0
#include "ndg/placement/skin_section.h"

#include <algorithm>
#include <cmath>

namespace ndg {

void widen_section(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                   const std::vector<char>& inside, double y, double half_width, Section& section)
{
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        for (int k = 0; k < 3; ++k) {
            const int a = triangles(t, k), b = triangles(t, (k + 1) % 3);
            const double ya = vertices(a, 1), yb = vertices(b, 1);
            if ((ya > y) == (yb > y)) continue;
            if (!inside.empty() && (!inside[a] || !inside[b])) continue;
            const Eigen::RowVector3d point =
                vertices.row(a) + (y - ya) / (yb - ya) * (vertices.row(b) - vertices.row(a));
            if (std::abs(point[0]) > half_width) continue;
            section.half_width = std::max(section.half_width, std::abs(point[0]));
            section.back = std::min(section.back, point[2]);
            section.front = std::max(section.front, point[2]);
        }
    }
}

}  // namespace ndg
