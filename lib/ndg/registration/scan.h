// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"

#include <string>

namespace ndg {

/// A scan of a person: a triangle mesh, or a point cloud when it has no triangles. Metres, y up.
struct Scan {
    Points vertices;      ///< N x 3
    Triangles triangles;  ///< T x 3, may be empty
    Points normals;       ///< N x 3 unit normals, outward; zero rows where unknown
};

}  // namespace ndg
