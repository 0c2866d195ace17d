// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body_source/template_source.h"
#include "ndg/core/options.h"
#include "ndg/wraps/wrap_skin.h"

#include <vector>

namespace ndg {

struct AnatomyWrapOptions {
    double min_scaled_jacobian = 0.08;  ///< of every prism at its corners and quadrature points
    double bone_margin = 0.0008;        ///< m between the bones and the bone wrap
    double muscle_margin = 0.0005;      ///< m between the muscles and the muscle wrap
    double min_thickness = 0.0008;      ///< m of either layer
};
void describe(OptionList& list, AnatomyWrapOptions& options);

/// Bone wrap around all bones and muscle wrap around all muscles and bones of the volumetric region (NDG 3.1, Figure
/// 2), in the tessellation of `skin` and inside each other: bones < bone wrap < muscle wrap < skin. `anatomy` lies
/// inside the skin (cover_with_skin). No prism is invalid and no two of the three surfaces intersect. Throws Error
/// naming the worst place when that cannot be reached.
Wraps anatomy_wraps(const WrapSkin& skin, const std::vector<AnatomyMesh>& anatomy, const AnatomyWrapOptions& options);

}  // namespace ndg
