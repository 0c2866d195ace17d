// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"

#include <vector>

namespace ndg {

/// Joins vertices at the same place, drops triangles without area and turns triangles so that neighbours across an edge
/// agree. Returns the part of each triangle: parts hang together by edges of two triangles. Whether a part faces
/// outwards is left open.
std::vector<int> join_parts(Points& vertices, Triangles& triangles);

/// Turns the normals of every part that faces inwards, and returns how many parts were turned. From samples on either
/// side of a part, rays are followed through the scan's occupied cells: the outer side is the one from which more of
/// them leave the scan (after Takayama et al. 2014). Works for parts with holes and open shells. `parts`: N labels;
/// `spacing`: between neighbouring points.
int turn_outwards(const Eigen::Ref<const Points>& points, double spacing, const std::vector<int>& parts,
                  Points& normals);

}  // namespace ndg
