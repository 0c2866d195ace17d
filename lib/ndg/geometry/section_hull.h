// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"

#include <vector>

namespace ndg {

/// What a tape around a limb follows: the convex hull of a section, in a plane.
struct SectionHull {
    Eigen::Vector3d centre, normal, u, w;  ///< of the plane: origin, unit normal, axes in it; u x w = normal
    std::vector<Eigen::Vector2d> points;   ///< counter-clockwise about the normal, by u and w; empty: nothing is cut

    double girth() const;
    Eigen::Vector3d in_space(const Eigen::Vector2d& point) const { return centre + point[0] * u + point[1] * w; }
};

/// Hull of that closed part of the section with the plane through `centre` which surrounds `centre`; of the nearest
/// part where none does. `normal` of any length.
SectionHull section_hull(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                         const Eigen::Vector3d& centre, const Eigen::Vector3d& normal);

}  // namespace ndg
