// SPDX-License-Identifier: Apache-2.0
// Finite elements with one deformation gradient F, linear in their corners: F^T = G X with X one corner a row.
#pragma once

#include "ndg/geometry/prism.h"
#include "ndg/geometry/tetrahedra.h"

#include <Eigen/LU>

namespace ndg {

/// One corner a row.
template <int Corners>
Eigen::Matrix<double, Corners, 3> corner_positions(const Eigen::Ref<const Points>& vertices, const int* corners)
{
    Eigen::Matrix<double, Corners, 3> positions;
    for (int a = 0; a < Corners; ++a) positions.row(a) = vertices.row(corners[a]);
    return positions;
}

/// The prism of NDG 2026: F is its mean.
struct PrismElement {
    static constexpr int num_corners = 6;
    static constexpr const char* name = "prism";
    static double volume(const PrismVertices& rest) { return prism_volume(rest); }
    static PrismGradient gradient_operator(const PrismVertices& rest) { return prism_gradient_operator(rest); }
};

/// The linear tetrahedron.
struct TetrahedronElement {
    static constexpr int num_corners = 4;
    static constexpr const char* name = "tetrahedron";
    static double volume(const Eigen::Matrix<double, 4, 3>& rest)
    {
        return tetrahedron_volume(rest.row(0), rest.row(1), rest.row(2), rest.row(3));
    }
    static Eigen::Matrix<double, 3, 4> gradient_operator(const Eigen::Matrix<double, 4, 3>& rest)
    {
        Eigen::Matrix<double, 3, 4> gradient;
        gradient.leftCols<3>() = (rest.topRows<3>().rowwise() - rest.row(3)).inverse();
        gradient.col(3) = -gradient.leftCols<3>().rowwise().sum();
        return gradient;
    }
};

}  // namespace ndg
