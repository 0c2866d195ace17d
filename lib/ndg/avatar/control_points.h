// SPDX-License-Identifier: Apache-2.0
// Few control points on a surface, and the smooth field that values at them make (Romero et al. 2020, 4.4).
#pragma once

#include "ndg/core/types.h"

#include <vector>

namespace ndg {

/// Of a left-right symmetric field: `vertices` lie on the half with x >= `plane_x` or in the plane; each stands for a
/// point on the other half too.
struct ControlPoints {
    std::vector<int> vertices;  ///< C
    std::vector<int> mirrored;  ///< C: nearest vertex to the mirror image, -1 for one in the plane (or near it)
    int size() const { return static_cast<int>(vertices.size()); }
};

/// Farthest-point sampling over the half x >= `plane_x` by straight distance; the first point is the one farthest from
/// the mean. Ties go to the lower index. Throws InputError for more points than vertices there.
ControlPoints place_control_points(const Eigen::Ref<const Points>& vertices, int count, double plane_x);

/// N x C: what each control point's value contributes at each vertex. Biharmonic: weights minimise the integral of the
/// squared Laplacian with 1 at their own points (both sides) and 0 at the others, level at the
/// surface's boundary (Jacobson et al. 2011 with their bounds left out); negative parts are then cut off and rows
/// scaled to sum one, so that fields stay between the least and the greatest value. Points keep their value exactly.
/// Throws SolverError where a part of the surface holds too few points.
RowMatrix control_point_weights(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                                const ControlPoints& points);

}  // namespace ndg
