// SPDX-License-Identifier: Apache-2.0
// The inside of the bone wrap: closed over the cuts, filled with tetrahedra, carried to other bodies.
#pragma once

#include "ndg/body/closed_wrap.h"
#include "ndg/core/types.h"

namespace ndg {

struct BoneInterior {
    Points vertices;        ///< N_i x 3: centres of the caps first, then vertices added by TetGen
    Tetrahedra tetrahedra;  ///< index < N_w: bone wrap vertex, otherwise N_w + interior vertex
    RowMatrix weights;      ///< N_i x J: skinning weights, harmonic on the edges of the tetrahedra
};

/// Fills the closed bone wrap with TetGen. `wrap_weights`: N_w x J dense. Throws as `tetrahedralize` does.
BoneInterior fill_bone_wrap(const Eigen::Ref<const Points>& bone_wrap,
                            const Eigen::Ref<const Triangles>& wrap_triangles,
                            const Eigen::Ref<const RowMatrix>& wrap_weights);

/// Interior vertices for another bone wrap of the same tessellation: the template's, displaced by the harmonic
/// extension of the wrap's displacement. N_i x 3.
Points transfer_interior(const Eigen::Ref<const Points>& template_bone_wrap,
                         const Eigen::Ref<const Points>& template_interior,
                         const Eigen::Ref<const Tetrahedra>& tetrahedra, const Eigen::Ref<const Points>& bone_wrap);

}  // namespace ndg
