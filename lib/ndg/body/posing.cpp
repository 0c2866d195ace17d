// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/posing.h"

namespace ndg {

void describe(OptionList& list, PosingOptions& options)
{
    list.add("bone-wrap", options.bone_wrap,
             "what moves the bone wrap: bones that stay rigid, or linear blend skinning as in the paper");
}

PosingOptions read_posing(const H5Reader& reader)
{
    if (!reader.has_attribute("bone_wrap")) return {BoneWrap::lbs};
    return {parse_name<BoneWrap>(reader.attribute("bone_wrap"), reader.path() + ": bone_wrap")};
}

void write_posing(H5Writer& writer, const PosingOptions& options)
{
    writer.attribute("bone_wrap", to_name(options.bone_wrap));
}

}  // namespace ndg
