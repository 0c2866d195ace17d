// SPDX-License-Identifier: Apache-2.0
// What can be chosen about posing bodies, whoever poses them.
#pragma once

#include "ndg/core/options.h"
#include "ndg/io/h5.h"

namespace ndg {

/// What moves the bone wrap, the Dirichlet values of every solve. rigid: the bones, each of which moves as a rigid body
/// (bones/bone_motion.h). lbs: linear blend skinning, as in the paper.
enum class BoneWrap { lbs, rigid };
template <>
inline constexpr EnumName<BoneWrap> enum_table<BoneWrap>[] = {{BoneWrap::lbs, "lbs"}, {BoneWrap::rigid, "rigid"}};

struct PosingOptions {
    BoneWrap bone_wrap = BoneWrap::rigid;
};
void describe(OptionList& list, PosingOptions& options);

/// The attribute `bone_wrap` of files of posed bodies. Files from before there was a choice do not have it: their
/// bodies were posed by linear blend skinning.
PosingOptions read_posing(const H5Reader& reader);
void write_posing(H5Writer& writer, const PosingOptions& options);

}  // namespace ndg
