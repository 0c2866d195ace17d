// SPDX-License-Identifier: Apache-2.0
// Plane sections of closed surfaces as filled, outlined bands.
#pragma once

#include "ndg/scene/image.h"
#include "ndg/scene/scene_surface.h"

#include <vector>

namespace ndg {

/// The plane through `origin` spanned by the unit vectors `right` and `up`, seen against right x up.
struct SectionPlane {
    Eigen::Vector3d origin = Eigen::Vector3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::UnitX();
    Eigen::Vector3d up = Eigen::Vector3d::UnitY();
};

/// Where a triangle crosses the plane, in plane coordinates (metres along right and up), directed so that the inside of
/// an outward-facing closed surface lies to the left.
struct SectionSegment {
    Eigen::Vector2d begin, end;
};
std::vector<SectionSegment> section_segments(const Eigen::Ref<const Points>& vertices,
                                             const Eigen::Ref<const Triangles>& triangles, const SectionPlane& plane);

/// Closes every boundary loop of a surface with a fan about the loop's centre, so that its sections are closed curves.
/// The new vertices come after the old ones.
SceneSurface closed_surface(const SceneSurface& surface);

struct SectionSettings {
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< plane coordinates of the image centre, metres
    double pixels_per_metre = 1000;
    int width = 600, height = 400;
    Eigen::Vector3f background = Eigen::Vector3f(0.955f, 0.96f, 0.965f);
    double line_width = 1.4;  ///< pixels
};
/// Fills the inside (winding number other than 0) of each surface in its colour over the surfaces before it and
/// outlines it in a darker tone of that colour. Surfaces must be closed; ones that the plane misses draw nothing.
Image section_image(const std::vector<SceneSurface>& surfaces, const SectionPlane& plane,
                    const SectionSettings& settings);

}  // namespace ndg
