// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body_source/template_source.h"
#include "ndg/procedural/field.h"
#include "ndg/procedural/layout.h"

#include <vector>

namespace ndg {

/// Least depth under the skin that procedural_anatomy keeps, m: bones (fingers and toes have less flesh) and muscles.
constexpr double bone_cover = 0.004, digit_bone_cover = 0.0022, muscle_cover = 0.0025;

/// Bones, then muscles of a person: bones inside the skin by bone_cover, muscles outside the bones and inside the skin
/// by muscle_cover. Deterministic.
std::vector<AnatomyMesh> procedural_anatomy(const BodyLayout& layout);

}  // namespace ndg
