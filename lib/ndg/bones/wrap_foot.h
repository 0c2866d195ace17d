// SPDX-License-Identifier: Apache-2.0
// Where on a wrap a point lies, found from where it lay before.
#pragma once

#include "ndg/bones/surface_spread.h"

#include <array>
#include <vector>

namespace ndg {

/// Which triangles of a surface lie beside which.
struct SurfaceNeighbours {
    SurfaceNeighbours(const Eigen::Ref<const Triangles>& triangles, int num_vertices);

    Triangles triangles;
    std::vector<std::array<int, 3>> beside;      ///< of each triangle, across the edge opposite to a corner; -1: none
    std::vector<std::vector<int>> triangles_of;  ///< of each vertex
};

/// Where on the wrap a point lies.
struct WrapFoot {
    int triangle = -1;
    float height = 0.0F;                                 ///< of the point (m), negative inside
    Eigen::Vector3f outwards = Eigen::Vector3f::Zero();  ///< of length 1, along the line to the point
    Eigen::Vector3f barycentric = Eigen::Vector3f::Zero();
};

/// Goes over the wrap from triangle to triangle to one under or over the point: a bone that slides under the wrap is
/// followed, and another fold of the wrap that touches this one is not taken for it. Where the point lies over an edge
/// and may be higher than `allowed` (m), the nearest place is looked for. Of a point under an edge only triangle and
/// height are told. `wrap`: 4 x N.
WrapFoot find_foot(const SurfaceNeighbours& surface, const PointColumnsF& wrap, const Eigen::Vector3f& point, int start,
                   float allowed);

}  // namespace ndg
