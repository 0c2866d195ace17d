// SPDX-License-Identifier: Apache-2.0
// Discrete shell energies of the skin, per edge (NDG equations 5 and 6; Grinspun et al. 2003), without the stiffness
// factors k_b and k_s. Vectors stack the points' coordinates: (x0, x1) or (x0, x1, left, right).
#pragma once

#include <Eigen/Core>

namespace ndg {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector12 = Eigen::Matrix<double, 12, 1>;
using Matrix12 = Eigen::Matrix<double, 12, 12>;

/// 1/2 (l - rest_length)^2 / rest_length^2.
double stretch_energy(const Eigen::Vector3d& x0, const Eigen::Vector3d& x1, double rest_length);
Vector6 stretch_gradient(const Eigen::Vector3d& x0, const Eigen::Vector3d& x1, double rest_length);
Matrix6 stretch_hessian(const Eigen::Vector3d& x0, const Eigen::Vector3d& x1, double rest_length);
/// With the one eigenvalue that can be negative (across a compressed edge) set to zero.
Matrix6 stretch_projected_hessian(const Eigen::Vector3d& x0, const Eigen::Vector3d& x1, double rest_length);

/// A hinge: the edge x0 -> x1 and the opposite vertices of its left and right triangle (mesh_edges).
struct Hinge {
    Eigen::Vector3d x0, x1, left, right;
};
/// Derivatives of the dihedral angle (dihedral_angle in geometry/triangle_mesh.h); Tamstorf and Grinspun 2013.
Vector12 dihedral_gradient(const Hinge& hinge);
Matrix12 dihedral_hessian(const Hinge& hinge);

/// 1/2 weight (theta - rest_angle)^2, weight = rest_length^2 / rest_area. The difference is taken in (-pi, pi].
double bend_energy(const Hinge& hinge, double rest_angle, double weight);
Vector12 bend_gradient(const Hinge& hinge, double rest_angle, double weight);
Matrix12 bend_hessian(const Hinge& hinge, double rest_angle, double weight);
/// With negative eigenvalues set to zero.
Matrix12 bend_projected_hessian(const Hinge& hinge, double rest_angle, double weight);

}  // namespace ndg
