// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/procedural/layout.h"
#include "ndg/procedural/surface.h"

namespace ndg {

/// Dense skinning weights of the whole surface on the standard skeleton, N x 60: along every chain of bones smooth
/// ramps centred on the joints, chains joined by the distance to their part of the skin, then smoothed along the
/// surface. At most 8 entries a row are not zero, rows sum to one, left and right mirror each other.
RowMatrix procedural_weights(const BodyLayout& layout, const Field& field, const SymmetricSurface& surface);

/// Where the bones' motion from one layout to another takes points: every joint moves as a rotation with stretch along
/// its bone and a common scale across, blended by `weights` (N x 60).
Points carry_points(const BodyLayout& from, const BodyLayout& to, const Eigen::Ref<const RowMatrix>& weights,
                    const Eigen::Ref<const Points>& points);

}  // namespace ndg
