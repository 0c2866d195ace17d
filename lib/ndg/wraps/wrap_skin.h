// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"

namespace ndg {

/// The volumetric skin of one body and what making its wraps needs to know about it.
struct WrapSkin {
    Points vertices;         ///< N_w x 3
    Triangles triangles;     ///< T_w x 3, outward
    RowMatrix weights;       ///< N_w x J, dense
    Points joint_positions;  ///< J x 3
};

/// Inner wraps whose prisms are all valid.
struct Wraps {
    Points bone;                       ///< N_w x 3
    Points muscle;                     ///< N_w x 3
    double min_scaled_jacobian = 0.0;  ///< over both layers
};

}  // namespace ndg
