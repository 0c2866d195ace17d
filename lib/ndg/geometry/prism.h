// SPDX-License-Identifier: Apache-2.0
// The triangular prism element: gradient operator, exact volume, Jacobians, local coordinates.
// Source: NDG 2026 supplement, sections 1 and 2. Vertex order: rows 0-2 the outer triangle (xi = 1), rows 3-5 the inner
// one (xi = 0), so that det J > 0 for outward-facing triangles (VTK_WEDGE).
#pragma once

#include "ndg/core/types.h"

#include <Eigen/SparseCore>

namespace ndg {

/// 6 x 3 vertex positions of one prism.
using PrismVertices = Eigen::Matrix<double, 6, 3>;
/// 3 x 6 gradient operator G with F^T = G P.
using PrismGradient = Eigen::Matrix<double, 3, 6>;

PrismVertices gather_prism(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Prisms>& prisms,
                           Eigen::Index prism_idx);

/// x(alpha, beta, xi), supplement equation 1 (row vector).
Eigen::RowVector3d prism_point(const PrismVertices& prism, double alpha, double beta, double xi);
/// The six shape functions at (alpha, beta, xi); they sum to one.
Eigen::Matrix<double, 6, 1> prism_shape_functions(double alpha, double beta, double xi);
/// J = (dx/dalpha, dx/dbeta, dx/dxi) as columns, supplement equation 11.
Eigen::Matrix3d prism_jacobian(const PrismVertices& prism, double alpha, double beta, double xi);
/// Signed volume, exact (supplement equation 15).
double prism_volume(const PrismVertices& prism);
/// d volume / d vertices, 6 x 3, exact.
PrismVertices prism_volume_gradient(const PrismVertices& prism);
/// d^2 volume / d vertices^2, exact: row and column 3 a + c are coordinate c of vertex a.
Eigen::Matrix<double, 18, 18> prism_volume_hessian(const PrismVertices& prism);
/// det J at a corner, m^3: six times the volume of the tetrahedron of its vertex and the three next to it. Its
/// derivatives are laid out as the volume's.
double prism_corner_jacobian(const PrismVertices& prism, int corner);
PrismVertices prism_corner_jacobian_gradient(const PrismVertices& prism, int corner);
Eigen::Matrix<double, 18, 18> prism_corner_jacobian_hessian(const PrismVertices& prism, int corner);
/// Smallest det J over the six corners and the two quadrature points, in m^3.
double prism_min_jacobian(const PrismVertices& prism);
/// Smallest det J over the six corners alone, m^3: of the posed prism it is negative where a corner is folded over,
/// which the volume may not show.
double prism_min_corner_jacobian(const PrismVertices& prism);
/// As prism_min_jacobian with every column of J scaled to unit length at each point and divided by that of the
/// equilateral right prism (sin 60 degrees): 1 is ideal, <= 0 invalid. 0 for degenerate columns.
double prism_min_scaled_jacobian(const PrismVertices& prism);

/// G of a rest prism (supplement equation 7). Throws Error when the prism is flat (singular normal matrix).
PrismGradient prism_gradient_operator(const PrismVertices& rest);

/// Stacked operator, (3 N_p) x N_v: rows 3p..3p+2 of G X are F_p^T.
Eigen::SparseMatrix<double> gradient_operator(const Eigen::Ref<const Points>& rest_vertices,
                                              const Eigen::Ref<const Prisms>& prisms);
/// F_p of every prism, row p = (F00, F01, F02, F10, ..., F22), i.e. F row-major. N_p x 9.
Eigen::Matrix<double, Eigen::Dynamic, 9, Eigen::RowMajor> deformation_gradients(
    const Eigen::SparseMatrix<double>& gradient_operator, const Eigen::Ref<const Points>& vertices);
/// Exact signed volume of every prism, N_p.
Eigen::VectorXd prism_volumes(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Prisms>& prisms);

/// How many prisms are turned inside out, by two measures.
struct InvertedPrisms {
    int by_volume = 0;   ///< exact volume < 0 (E_inv of NDG 5.1)
    int at_corners = 0;  ///< det J < 0 at one of the six corners or more
};
InvertedPrisms count_inverted_prisms(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Prisms>& prisms);

/// (alpha, beta, xi) with prism_point(...) = point, by Newton's method; `converged` is false if none was found.
struct PrismCoordinates {
    double alpha = 0, beta = 0, xi = 0;
    bool converged = false;
};
PrismCoordinates prism_coordinates(const PrismVertices& prism, const Eigen::RowVector3d& point);

}  // namespace ndg
