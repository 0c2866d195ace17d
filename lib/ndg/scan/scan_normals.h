// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"
#include "ndg/geometry/point_tree.h"

namespace ndg {

/// Unit normals of a point cloud, N x 3: normal of the plane fitted to the `num_neighbours` nearest points (Hoppe et
/// al. 1992). Signs follow `hint` (N x 3), where that is not empty; else they are propagated along the graph of nearest
/// neighbours, most parallel neighbours first, and each connected part is turned outwards (scan_orientation.h).
Points estimate_normals(const Eigen::Ref<const Points>& points, const PointTree& tree, int num_neighbours,
                        const Eigen::Ref<const Points>& hint);

}  // namespace ndg
