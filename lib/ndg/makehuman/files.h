// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"

#include <string>
#include <vector>

namespace ndg {

/// A shape target: displacements of some vertices, decimetre.
struct MakeHumanTarget {
    std::vector<int> vertices;
    Points offsets;  ///< one row for each of `vertices`
};

/// Reads a gzipped text target ("vertex dx dy dz" a line). Throws InputError naming file, line and value.
MakeHumanTarget read_makehuman_target(const std::string& path, int num_vertices);

}  // namespace ndg
