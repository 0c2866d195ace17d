// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/anatomical/trunk.h"

#include <vector>

namespace ndg {

struct SkinFitReport {
    double outside_before = 0, outside_after = 0;  ///< share of the vertices of muscles and bones outside the skin
    double bone_displacement = 0;                  ///< root mean square over bone vertices, m
};

/// Fills the skin with the muscles: where the outermost muscle lies deeper than the layer of fat of that region it is
/// drawn out part of the way, where muscle or bone lies nearer to the skin than that, or outside, it is pushed in. Both
/// are one displacement field on coarse grids (DisplacementField); bones that need no room hold still in it. Head,
/// hands and toes are only pushed. The fat layers are choices, in the range of half the skinfolds of lean adults
/// (Durnin and Womersley 1974): see the table in the source. Deterministic.
/// `joint_positions`: moved along with the bones around them.
SkinFitReport fit_to_skin(std::vector<AnatomyMesh>& parts, Points& joint_positions, const AnatomyTarget& target);

}  // namespace ndg
