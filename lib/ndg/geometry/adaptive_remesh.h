// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/geometry/triangle_mesh.h"

#include <vector>

namespace ndg {

/// What remesh_adaptively aims at, for each vertex of its input.
struct RemeshField {
    Eigen::VectorXd edge_length;  ///< N, wanted edge length, m
    std::vector<char> fixed;      ///< N, vertices that stay; edges between two of them stay as well
};

/// Isotropic remeshing with a field of edge lengths (Botsch and Kobbelt 2004: split, collapse, flip, tangential
/// smoothing, projection; Dunyach et al. 2013 for the field), followed by a local search that widens small angles. The
/// surface may be open. Its boundary and the borders between labels are features: they are resampled along
/// themselves, and where they meet the vertex stays. All vertices lie on the input surface, those of features on the
/// input's features. Deterministic. Throws InputError for sizes that do not match or lengths that are not positive.
LabelledMesh remesh_adaptively(const TriangleMesh& mesh, const std::vector<int>& triangle_labels,
                               const RemeshField& field);

}  // namespace ndg
