// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/geometry/prism.h"

namespace ndg {

/// Where barriers begin and where they are infinite.
struct BarrierBounds {
    double jacobian, active_jacobian;    ///< scaled Jacobian
    double thickness, active_thickness;  ///< m
    double area, active_area;            ///< m^2, twice the area of the inner triangle
};

/// Sum of -(1 - y)^2 log y over the scaled Jacobians of a prism at its corners and quadrature points and over its
/// heights at the corners, and of twice the inner triangle's area, with y = 0 at the bound and y = 1 where the barrier
/// begins (barrier of Li et al. 2020, Incremental Potential Contact). Height: of an inner or outer vertex over the
/// plane of the opposite triangle's copy through its own, det J / |dx/dalpha x dx/dbeta|. Infinite at and beyond a
/// bound. What is not null is added to: `gradient` 6 x 3, `hessian` 18 x 18 (unknown 3 v + c), a positive semi-definite
/// approximation that takes the squares of first derivatives and, along each column of J, a bound of the scaled
/// Jacobian's own curvature.
double prism_barrier(const PrismVertices& prism, const BarrierBounds& bounds, PrismVertices* gradient,
                     Eigen::Matrix<double, 18, 18>* hessian);

/// Sum of (1 - value / active)^2 over those scaled Jacobians and heights (m) of a prism that lie below
/// `active_jacobian` and `active_thickness`: finite for invalid prisms too, which it turns round. `gradient` and
/// `hessian` as above.
double prism_penalty(const PrismVertices& prism, double active_jacobian, double active_thickness,
                     PrismVertices* gradient, Eigen::Matrix<double, 18, 18>* hessian);

/// Smallest scaled Jacobian, as prism_min_scaled_jacobian has it, smallest height in metres and twice the area of the
/// inner triangle.
Eigen::RowVector3d prism_quality(const PrismVertices& prism);

}  // namespace ndg
