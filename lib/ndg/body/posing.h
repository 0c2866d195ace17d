// SPDX-License-Identifier: Apache-2.0
// What can be chosen about posing bodies, whoever poses them.
#pragma once

#include "ndg/core/options.h"

namespace ndg {

/// What moves the bone wrap, the Dirichlet values of every solve. lbs: linear blend skinning, as in the paper. rigid:
/// the bones, each of which moves as a rigid body (bones/bone_motion.h).
enum class BoneWrap { lbs, rigid };
template <>
inline constexpr EnumName<BoneWrap> enum_table<BoneWrap>[] = {{BoneWrap::lbs, "lbs"}, {BoneWrap::rigid, "rigid"}};

struct PosingOptions {
    BoneWrap bone_wrap = BoneWrap::lbs;
};
void describe(OptionList& list, PosingOptions& options);

}  // namespace ndg
