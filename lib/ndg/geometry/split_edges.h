// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"

#include <functional>

namespace ndg {

/// Splits edges at their middle until none is longer than `length`; a closed surface stays closed. Columns 0-2 of
/// `attributes` are positions; further columns are interpolated linearly. New vertices lie on the old triangles and
/// follow the old ones in order.
void split_long_edges(RowMatrix& attributes, Triangles& triangles, double length);

/// Whether an edge from `a` to `b` is to be split; the order of its ends must not matter.
using SplitsEdge = std::function<bool(const Eigen::Vector3d& a, const Eigen::Vector3d& b)>;

/// The same for edges that a rule names. It must let short edges be: after twelve rounds the rest stays as it is.
void split_edges(RowMatrix& attributes, Triangles& triangles, const SplitsEdge& splits);

}  // namespace ndg
