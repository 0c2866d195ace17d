// SPDX-License-Identifier: Apache-2.0
// Anatomy of other bodies and in other poses: embedded in the volume (NDG 3.3); beyond the cuts, where there is no
// volume, skinned.
#pragma once

#include "ndg/body/template.h"

#include <vector>

namespace ndg {

/// Skinning weights of embedded vertices: those of the vertices they combine. Rows of vertices that are not embedded
/// hold joint 0 with weight 1. `volume_weights`: N_v rows, `interior_weights`: N_i rows.
SkinningWeights embedded_weights(const Embedding& embedding, const SkinningWeights& volume_weights,
                                 const SkinningWeights& interior_weights, int num_joints);

/// Anatomy of a body at rest, N_a x 3: embedded vertices by the embedding; the others by similarity transforms, one a
/// joint, that take the template's skin around the joint to the body's (least squares, Umeyama 1991), blended by
/// Template::anatomy_weights.
Points anatomy_at_rest(const Template& body_template, const Body& body);

/// Anatomy of a deformed body, N_a x 3: embedded vertices from the deformed volume (N_v x 3) and bone interior
/// (N_i x 3), the others by linear blend skinning of `anatomy_rest` (anatomy_at_rest of that body).
Points deformed_anatomy(const Template& body_template, const Eigen::Ref<const Points>& anatomy_rest,
                        const Eigen::Ref<const Points>& volume_vertices,
                        const Eigen::Ref<const Points>& interior_vertices,
                        const std::vector<Eigen::Isometry3d>& world_from_rest);

}  // namespace ndg
