// SPDX-License-Identifier: Apache-2.0
// Broad phase of collision detection: which boxes overlap, by a grid of cells about as large as the boxes.
#pragma once

#include <Eigen/Core>

#include <utility>
#include <vector>

namespace ndg {

/// Axis-aligned boxes, one a row: three lower and three upper bounds.
using Boxes = Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>;

/// Boxes of sets of vertices with as many corners each, made larger by `margin` on all sides.
template <class Positions, class Corners>
Boxes bounding_boxes(const Positions& vertices, const Corners& corners, double margin = 0)
{
    Boxes boxes(corners.rows(), 6);
    for (Eigen::Index i = 0; i < corners.rows(); ++i) {
        auto low = boxes.row(i).template head<3>(), high = boxes.row(i).template tail<3>();
        low = high = vertices.row(corners(i, 0));
        for (Eigen::Index a = 1; a < corners.cols(); ++a) {
            low = low.cwiseMin(vertices.row(corners(i, a)));
            high = high.cwiseMax(vertices.row(corners(i, a)));
        }
        low.array() -= margin;
        high.array() += margin;
    }
    return boxes;
}

/// Pairs (i of the first, j of the second) of boxes that overlap or touch, ascending. Boxes must be finite.
std::vector<std::pair<int, int>> overlapping_boxes(const Boxes& first, const Boxes& second);

}  // namespace ndg
