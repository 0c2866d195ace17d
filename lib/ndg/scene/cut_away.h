// SPDX-License-Identifier: Apache-2.0
// Surfaces and flesh cut by a plane, as surfaces: what a plane takes away casts no shadow either.
#pragma once

#include "ndg/scene/body_surfaces.h"
#include "ndg/scene/render.h"

#include <vector>

namespace ndg {

/// What remains of a surface behind the plane; triangles that cross it are cut, colours interpolated.
SceneSurface cut_surface(const SceneSurface& surface, const ClipPlane& plane);

/// Where the plane cuts prisms (rows of `prisms` into `vertices`, in the order of the template's): triangles that face
/// the side that is cut away. Their vertices are not shared. Without triangles where the plane misses.
SceneSurface cut_face(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Prisms>& prisms,
                      const ClipPlane& plane);

/// A body whose skin and fat are taken away in front of the plane: the skin behind it, the cut face of the fat, and
/// inside muscles and bones, or the muscle wrap of a template without muscles.
std::vector<SceneSurface> cut_away_surfaces(const Template& body_template, const BodyGeometry& geometry,
                                            const ClipPlane& plane);

}  // namespace ndg
