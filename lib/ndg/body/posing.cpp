// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/posing.h"

namespace ndg {

void describe(OptionList& list, PosingOptions& options)
{
    list.add("bone-wrap", options.bone_wrap,
             "what moves the bone wrap: linear blend skinning, as in the paper, or bones that stay rigid");
}

}  // namespace ndg
