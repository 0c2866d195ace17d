// SPDX-License-Identifier: Apache-2.0
// Where the template's bone wrap goes in another body.
#pragma once

#include "ndg/body/template.h"
#include "ndg/core/types.h"
#include "ndg/placement/trunk_map.h"

namespace ndg {

/// The template's bone wrap carried into a body, blended by `weights` (N_w x J): what hangs on pelvis, spine and neck
/// by `trunk`; what hangs on a clavicle too, and with the shoulder's joint towards the side; limbs by one transform a
/// joint. Along the bones that has the length between the joints (`joint_positions`, J x 3); across long bones the root
/// of that and of `scale`, the stature's, and a little more for a greater `bmi` (kg/m^2), or less where the bones would
/// else come out of `skin_wrap` (N_w x 3): 4 percent of a joint's vertices may, the left and the right joint shrink
/// alike. N_w x 3.
Points carried_bone_wrap(const Template& body_template, const Eigen::Ref<const RowMatrix>& weights,
                         const Eigen::Ref<const Points>& skin_wrap, const Eigen::Ref<const Points>& joint_positions,
                         double scale, double bmi, const TrunkMap& trunk);

/// Moves `bone_wrap` inwards where it lies less than `depth` (m) under the skin along the skin's normal, by amounts
/// that vary smoothly along the surface: least squares of their umbrella Laplacian and of themselves, tied to what is
/// needed where they fall short of it.
void press_under_skin(const Eigen::Ref<const Points>& skin_wrap, const Eigen::Ref<const Triangles>& triangles,
                      double depth, Points& bone_wrap);

}  // namespace ndg
