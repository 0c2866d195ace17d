// SPDX-License-Identifier: Apache-2.0
// The part of a skin that has soft tissue below it, and the closed surface of that tissue.
#pragma once

#include "ndg/core/types.h"
#include "ndg/geometry/triangle_mesh.h"

#include <string>
#include <vector>

namespace ndg {

/// W vertices of a skin of N, R of them on rims, where the region ends.
struct SoftRegion {
    std::vector<int> skin_vertices;     ///< W: skin vertex of each
    std::vector<int> region_of_skin;    ///< N: number in the region, -1 outside
    Triangles triangles;                ///< T_w x 3, numbers in the region, outward
    std::vector<int> rim;               ///< R numbers in the region, ascending
    std::vector<int> outer;             ///< W: volume vertex of each region vertex (see layer_surface)
    std::vector<double> rim_distances;  ///< W: along edges to the nearest rim vertex, m

    int size() const { return static_cast<int>(skin_vertices.size()); }
};

/// The region of the triangles with flag 1. Those at vertices where it would touch itself are left out, until its
/// edges and vertices are those of a surface with boundary, and so are pieces of less than a hundredth of its
/// triangles. Throws InputError where nothing is left, where a piece has no rim, and where the triangles are no
/// surface.
SoftRegion soft_region(const Eigen::Ref<const Points>& skin_vertices, const Eigen::Ref<const Triangles>& skin_triangles,
                       const std::vector<int>& soft_triangles);

/// Triangles that `joints` and their descendants move by less than half: 0 for the others. `weights`: N x K.
std::vector<int> soft_triangles_without(const Eigen::Ref<const Triangles>& skin_triangles,
                                        const Eigen::Ref<const RowMatrix>& weights, const std::vector<int>& parents,
                                        const std::vector<int>& joints);

/// Outer vertices `inward` * `thickness` further in, W x 3.
Points inner_surface(const Eigen::Ref<const Points>& outer, const Eigen::Ref<const Points>& inward,
                     const std::vector<double>& thickness);

/// The closed outward surface of the layer: inner vertices (W), outer vertices of the rims (R), other outer vertices
/// (W - R); the region's triangles, the same inside, and a band of two triangles an edge along the rims.
TriangleMesh layer_surface(const SoftRegion& region, const Eigen::Ref<const Points>& outer,
                           const Eigen::Ref<const Points>& inner);

}  // namespace ndg
