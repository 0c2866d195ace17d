// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/deform/deformer.h"

namespace ndg {

/// "lbs": linear blend skinning of all volume vertices.
void register_lbs(MethodTable& table);

}  // namespace ndg
