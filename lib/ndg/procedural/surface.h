// SPDX-License-Identifier: Apache-2.0
// The procedural skin as a mesh: made once, then carried from person to person.
#pragma once

#include "ndg/core/types.h"
#include "ndg/procedural/field.h"
#include "ndg/procedural/layout.h"

#include <vector>

namespace ndg {

/// A closed surface that is its own mirror image in x = 0. The first `num_half` vertices lie on x >= 0, the first
/// `num_middle` of these on x = 0; the others mirror the vertices num_middle..num_half-1, in order.
struct SymmetricSurface {
    Points vertices;
    Triangles triangles;
    int num_middle = 0, num_half = 0;

    /// The whole from its left half (num_half rows).
    Points complete(const Eigen::Ref<const Points>& half) const;
};

/// Meshes the skin: finer at hands, head and feet. Deterministic.
SymmetricSurface mesh_skin(const BodyLayout& layout, const Field& field);

/// Vertices of the left half (num_half rows) moved onto the zero surface of `field`. `carried` is where they would go
/// with the bones, near the surface and well shaped; the displacement from there is smoothed over the mesh and the
/// result taken back to the surface, `rounds` times, so that triangles keep their shape.
Points settle_on_skin(const SymmetricSurface& surface, const Eigen::Ref<const Points>& carried, const Field& field,
                      int rounds);

}  // namespace ndg
