// SPDX-License-Identifier: Apache-2.0
// Discrete shell energies of the skin, per edge (NDG equations 5 and 6; Grinspun et al. 2003). Vectors stack the
// points' coordinates: (x0, x1) or (x0, x1, left, right).
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

/// What a hinge's bending energy refers to.
///
/// weight = k_b l^2 / A with edge length l and A a third of the sum of the two triangles' areas, all at rest (NDG
/// equation 5). The third is that of Grinspun et al. 2003, section 3: an edge stands for the strip of shell about it
/// whose width h is a third of the mean height of its two triangles, and the energy is the sum of (change of angle)^2
/// l / h. With heights 2 area / l, l / h = 3 l^2 / (left area + right area).
struct HingeRest {
    double angle = 0;
    double weight = 0;      ///< joule
    double left_area = 0;   ///< m^2, of the left triangle
    double right_area = 0;  ///< m^2, of the right triangle
};
/// A triangle squeezed to less than this share of its rest area fades out of the bending energy: as it collapses to a
/// line its angle loses meaning and the forces of the energy as published grow without bound.
constexpr double bend_fade_share = 0.1;

/// 1/2 weight (theta - angle)^2 fade(left) fade(right). The difference is taken in (-pi, pi]; fade is 1 above
/// bend_fade_share, 0 at area zero, and twice continuously differentiable between.
double bend_energy(const Hinge& hinge, const HingeRest& rest);
Vector12 bend_gradient(const Hinge& hinge, const HingeRest& rest);
Matrix12 bend_hessian(const Hinge& hinge, const HingeRest& rest);
/// A lower bound of the Hessian's smallest eigenvalue over the angle's stiffness, without the fading triangles' share.
double bend_stability(const Hinge& hinge, const HingeRest& rest);
/// With negative eigenvalues set to zero.
Matrix12 bend_projected_hessian(const Hinge& hinge, const HingeRest& rest);
/// The share of the angle's own stiffness alone: positive semi-definite and cheap.
Matrix12 bend_gauss_newton_hessian(const Hinge& hinge, const HingeRest& rest);

}  // namespace ndg
