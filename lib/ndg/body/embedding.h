// SPDX-License-Identifier: Apache-2.0
// Anatomy carried by the volume (NDG 3.3, supplement equation 1).
#pragma once

#include "ndg/core/types.h"

#include <vector>

namespace ndg {

/// Each embedded vertex is a fixed combination of at most six volume vertices.
struct Embedding {
    /// N_a: prism index p, or N_p + tetrahedron index, or -1 for a vertex that is not embedded (its weights are zero).
    std::vector<int> elements;
    /// N_a x 6 vertex indices into [volume vertices; interior vertices]; unused columns 0 with weight 0.
    Eigen::Matrix<int, Eigen::Dynamic, 6, Eigen::RowMajor> vertices;
    /// N_a x 6 weights, rows sum to one.
    Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor> weights;
    /// N_a: distance in metres to the element when the vertex lies in none (then the nearest is taken); 0 inside.
    std::vector<double> distances;
};

/// Finds the element of every point. `tetrahedra` index < num_wrap_vertices: bone wrap vertex (= volume vertex),
/// otherwise num_wrap_vertices + interior vertex, as in Template.
Embedding embed_points(const Eigen::Ref<const Points>& points, const Eigen::Ref<const Points>& volume_vertices,
                       const Eigen::Ref<const Prisms>& prisms, const Eigen::Ref<const Points>& interior_vertices,
                       const Eigen::Ref<const Tetrahedra>& tetrahedra, int num_wrap_vertices);

/// Positions of the embedded vertices for deformed (or another body's) volume and interior vertices, N_a x 3.
Points apply_embedding(const Embedding& embedding, const Eigen::Ref<const Points>& volume_vertices,
                       const Eigen::Ref<const Points>& interior_vertices);

}  // namespace ndg
