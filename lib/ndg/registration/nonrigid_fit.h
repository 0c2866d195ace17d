// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/registration/articulated_fit.h"

#include <Eigen/SparseCore>

namespace ndg {

struct NonrigidFitOptions {
    int iterations = 12;
    /// Wavelength of displacements at which data and regulariser balance, m: first and last iteration, geometric in
    /// between. The weight of the regulariser is (wavelength / 2 pi)^4.
    double first_wavelength = 0.60, last_wavelength = 0.06;
    double first_reach = 0.03, last_reach = 0.006;  ///< of the robust weights, m
    double tangential = 0.002;  ///< weight of staying where the last iteration left a vertex, against distances' 1
    int scan_samples = 30000;   ///< scan points matched to the surface
};
void describe(OptionList& list, NonrigidFitOptions& options);

/// How stiff the surface is, relative to ordinary skin, for each vertex: `armpit_factor` (1e4 in NDG 4.1) within
/// `armpit_radius` (m) of the armpits, fading out to twice that; 1e2 at hands, face and toes, whose detail a scan does
/// not show.
Eigen::VectorXd stiffness_weights(const SkinnedSurface& skin, double armpit_factor, double armpit_radius);

/// Non-rigid registration (Achenbach et al. 2017, without their PCA step): from `start`, minimises
///   sum_c a_c w_c (n_c . (x_c - p_c))^2 + (wavelength / 2 pi)^4 sum_i s_i A_i |L x_i - R_i L x_i^ref|^2
/// over closest points c both ways (areas a_c, robust weights w_c), L the cotangent Laplacian of the reference divided
/// by vertex areas A_i, R_i the rotation of a vertex's neighbourhood, re-estimated before each solve, s_i the stiffness
/// weights. Where the scan has holes no matches stand and the surface follows its neighbours smoothly. Each step is a
/// normal system solved by conjugate gradients, preconditioned by a sparse Cholesky factorisation of its regulariser
/// and areas. `reference`: the posed template, N x 3. `confidence`: N, how much the matches of a vertex count that lies
/// inside the scan; empty: one; where it is zero the surface follows its neighbours too, but not out of the scan.
Points fit_nonrigid(const Eigen::Ref<const Points>& reference, const Eigen::Ref<const Triangles>& triangles,
                    const ScanTarget& scan, const Eigen::Ref<const Points>& start, const Eigen::VectorXd& stiffness,
                    const NonrigidFitOptions& options, const Eigen::VectorXd& confidence = {});

/// `vertices` where `confidence` (N, 0 to 1) is one, and the shape of `reference` where it is zero, joined smoothly:
/// minimises sum_i A_i c_i |x_i - v_i|^2 + (wavelength / 2 pi)^4 sum_i A_i |L x_i - R_i L x_i^ref|^2, as above.
Points complete_surface(const Eigen::Ref<const Points>& reference, const Eigen::Ref<const Triangles>& triangles,
                        const Eigen::Ref<const Points>& vertices, const Eigen::VectorXd& confidence, double wavelength);

/// Rotation of the neighbourhood of each vertex from `reference` to `deformed`: polar factor of the covariance of its
/// edges weighted by `laplacian`'s entries (Sorkine and Alexa 2007).
std::vector<Eigen::Matrix3d> neighbourhood_rotations(const Eigen::SparseMatrix<double>& laplacian,
                                                     const Eigen::Ref<const Points>& reference,
                                                     const Eigen::Ref<const Points>& deformed);

}  // namespace ndg
