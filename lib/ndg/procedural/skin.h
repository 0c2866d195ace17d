// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/procedural/field.h"
#include "ndg/procedural/layout.h"

namespace ndg {

/// Tags of the parts of the skin's field; the fingers follow from thumb to little finger.
enum SkinPart : int { skin_trunk, skin_neck, skin_leg, skin_arm, skin_head, skin_foot, skin_palm, skin_finger_0 };

/// The skin as an implicit surface: trunk and limbs are tubes through cross sections after ANSUR II's breadths, depths
/// and circumferences (Gordon et al. 2014, tables of men and women, taken to a body mass index of 22 kg/m^2), widened
/// by muscle and by fat where each sex carries it; head, hands and feet are joined from simple forms.
Field skin_field(const BodyLayout& layout);

/// Parts of skin_field.
void add_trunk(Field& field, const BodyLayout& layout);
void add_neck(Field& field, const BodyLayout& layout);
void add_leg(Field& field, const BodyLayout& layout);
void add_arm(Field& field, const BodyLayout& layout);
void add_head(Field& field, const BodyLayout& layout);
void add_foot(Field& field, const BodyLayout& layout);
void add_hand(Field& field, const BodyLayout& layout);

}  // namespace ndg
