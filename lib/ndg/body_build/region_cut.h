// SPDX-License-Identifier: Apache-2.0
// Which part of the skin is volumetric: everything but head, hands and toes (NDG 3.1).
#pragma once

#include "ndg/core/types.h"

#include <vector>

namespace ndg {

/// Signed field on the vertices of a surface, negative in the volumetric region, positive in head, hands and toes: the
/// distance in metres to the cutting plane of the chain a vertex belongs to (by its weights), -1 far from any cut.
/// `weights`: N x J dense on the standard skeleton.
Eigen::VectorXd region_field(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const RowMatrix>& weights,
                             const Eigen::Ref<const Points>& joint_positions);

/// The surface with triangles split along the zero line of a vertex field, so that every triangle lies on one side.
struct CutSurface {
    Points vertices;  ///< input vertices first
    Triangles triangles;
    std::vector<int> triangle_labels;  ///< 1 where the field is negative, 0 where positive
};
/// Vertices with |field| below `snap` (metres) move onto the line instead of making slivers beside it: their field
/// value is taken as zero, their position stays.
CutSurface cut_along_zero(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                          const Eigen::VectorXd& field, double snap);

/// Label 1 for the triangles of a remeshed surface that lie in the volumetric region by their mean field value, 0 for
/// the others; single triangles that stick out over the border are taken to the other side, so that it runs smoothly.
std::vector<int> volumetric_labels(const Eigen::Ref<const Triangles>& triangles, const Eigen::VectorXd& field);

}  // namespace ndg
