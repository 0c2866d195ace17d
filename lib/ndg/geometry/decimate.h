// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/geometry/triangle_mesh.h"

#include <vector>

namespace ndg {

/// Takes vertices away until about `target_triangles` triangles with a label > 0 are left, or none can go: the edge
/// collapse with the least quadric error first (Garland and Heckbert 1997), always onto one of the edge's two vertices,
/// so that all vertices are vertices of the input. Triangles of label 0 and all their vertices stay; boundary and
/// borders between labels are collapsed along themselves only. No triangle turns over. Where `removable` is not empty
/// it says for each vertex whether it may go. Deterministic.
LabelledMesh decimate_labelled(const TriangleMesh& mesh, const std::vector<int>& triangle_labels,
                               std::size_t target_triangles, const std::vector<char>& removable = {});

}  // namespace ndg
