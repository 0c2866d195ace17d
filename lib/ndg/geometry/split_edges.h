// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"

namespace ndg {

/// Splits edges at their middle until none is longer than `length`; a closed surface stays closed. Columns 0-2 of
/// `attributes` are positions; further columns are interpolated linearly. New vertices lie on the old triangles and
/// follow the old ones in order.
void split_long_edges(RowMatrix& attributes, Triangles& triangles, double length);

}  // namespace ndg
