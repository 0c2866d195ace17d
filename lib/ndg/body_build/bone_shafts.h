// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/template.h"
#include "ndg/body_build/bone_interior.h"

namespace ndg {

/// A simple anatomy: one closed shaft for each long bone, the spine and the clavicles, along the skeleton, as thick as
/// anatomy says but never thicker than 80 % of the room inside the bone wrap.
struct Anatomy {
    Points vertices;  ///< N_a x 3
    Triangles triangles;
    std::vector<AnatomyPart> parts;
};
/// Where the axis leaves the bone wrap (at a cut, for instance) the shaft ends.
Anatomy make_bone_shafts(const Eigen::Ref<const Points>& joint_positions, const ClosedBoneWrap& bone_wrap);

}  // namespace ndg
