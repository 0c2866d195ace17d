// SPDX-License-Identifier: Apache-2.0
// What a horizontal plane cuts out of a surface.
#pragma once

#include "ndg/core/types.h"

#include <limits>
#include <vector>

namespace ndg {

struct Section {
    double half_width = 0.0;
    double back = std::numeric_limits<double>::max(), front = std::numeric_limits<double>::lowest();
    bool empty() const { return front < back; }
};

/// Widens `section` by the cut of the triangles marked in `inside` (per vertex; empty: all) at height y, as far as it
/// lies within `half_width` of the midline.
void widen_section(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                   const std::vector<char>& inside, double y, double half_width, Section& section);

}  // namespace ndg
