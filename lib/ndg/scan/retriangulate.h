// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/random.h"
#include "ndg/core/types.h"

namespace ndg {

/// Another triangulation of the same closed surface, with about `num_vertices` vertices: edges are split until they
/// have one length, then every vertex moves to a random place in one of its triangles and random edges between coplanar
/// triangles are flipped. Columns 0-2 of `attributes` are positions; further columns are interpolated linearly.
/// New vertices lie on the old triangles. A surface that has more vertices already is only jittered and flipped.
void retriangulate(RowMatrix& attributes, Triangles& triangles, int num_vertices, Random& random);

}  // namespace ndg
