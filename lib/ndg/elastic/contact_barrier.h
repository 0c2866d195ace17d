// SPDX-License-Identifier: Apache-2.0
// Energy that keeps the skin from itself (incremental potential contact, Li et al. 2020), of the squared distance D of
// a vertex and a triangle or of two edges:
//   b(D) = -(1 - D / R)^2 ln(D / R) for D < R, the squared reach, otherwise zero; without bound towards D = 0, twice
// continuously differentiable. That of two edges is multiplied by a factor that vanishes with all its force where they
// are parallel, for there their distance has a kink:
//   m(c) = (2 - c / e) c / e for c = |u x v|^2 < e, otherwise one.
#pragma once

#include <Eigen/Core>

namespace ndg {

/// Energy without unit and its derivatives by D.
struct ContactBarrier {
    double energy = 0, first = 0, second = 0;
};
/// Infinite for D = 0.
ContactBarrier contact_barrier(double squared_distance, double squared_reach);

/// m of edges from corner 0 to 1 and 2 to 3, and its derivatives by the corners' coordinates, stacked.
struct ParallelFade {
    double value = 1;
    Eigen::Matrix<double, 12, 1> gradient = Eigen::Matrix<double, 12, 1>::Zero();
    Eigen::Matrix<double, 12, 12> hessian = Eigen::Matrix<double, 12, 12>::Zero();
};
/// `limit`: e, of the fourth power of a length.
ParallelFade parallel_fade(const Eigen::Matrix<double, 4, 3>& corners, double limit);

}  // namespace ndg
