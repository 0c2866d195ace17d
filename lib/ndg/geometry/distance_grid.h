// SPDX-License-Identifier: Apache-2.0
// Distance fields on regular grids, and the closing of a triangle soup as a level set. They take meshes that are open,
// doubled or intersect themselves.
#pragma once

#include "ndg/core/types.h"

#include <vector>

namespace ndg {

/// Nodes origin + spacing (i, j, k), 0 <= i < size[0] and so on; i runs fastest.
struct GridBox {
    Eigen::Vector3d origin = Eigen::Vector3d::Zero();
    double spacing = 0.0;  ///< m
    Eigen::Array3i size = Eigen::Array3i::Zero();

    Eigen::Index count() const { return Eigen::Index(size[0]) * size[1] * size[2]; }
    Eigen::Index index(int i, int j, int k) const
    {
        return i + Eigen::Index(size[0]) * (j + Eigen::Index(size[1]) * k);
    }
    Eigen::Vector3d node(int i, int j, int k) const { return origin + spacing * Eigen::Vector3d(i, j, k); }
};
/// The grid that covers `points` and `margin` (m) around them.
GridBox grid_around(const Eigen::Ref<const Points>& points, double margin, double spacing);

/// Values in metres on the nodes of a grid.
struct ScalarGrid {
    GridBox box;
    std::vector<float> values;

    /// Trilinear between the nodes; outside the grid the value at the nearest point of it. `gradient` receives the
    /// derivative of just that function.
    double at(const Eigen::Vector3d& point, Eigen::Vector3d* gradient = nullptr) const;
};

/// Signed distance to an outward surface, which may be open: negative where the nearest point is seen from its back
/// (by vertex normals interpolated over the triangles). Exact within three spacings of the surface, beyond that
/// up to 0.4 spacing too large, a tenth of that on average. Throws Error when no triangle reaches into the grid.
ScalarGrid signed_distance_grid(const GridBox& box, const Eigen::Ref<const Points>& vertices,
                                const Eigen::Ref<const Triangles>& triangles);

/// Signed distance to the morphological closing of the triangles by a ball of `radius`: what no such ball that comes
/// from outside and touches no triangle can reach, cavities included. Negative in the closing. Where the ball touches
/// in two places at once the closing comes out up to a third of a spacing too small, elsewhere exact as above. The grid
/// should reach `radius` + 2 spacings beyond the triangles of interest; triangles outside of it are left out. Error as
/// above.
ScalarGrid closing_grid(const GridBox& box, const Eigen::Ref<const Points>& vertices,
                        const Eigen::Ref<const Triangles>& triangles, double radius);

}  // namespace ndg
