// SPDX-License-Identifier: Apache-2.0
// Residual deformation gradients: what is left of F_p once the pose-induced rotation is taken out (NDG equation 12,
// F_p = R_p F_p_res).
#pragma once

#include "ndg/core/types.h"

#include <vector>

namespace ndg {

/// N x 3 positions as files store them.
using PointsF = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// Deformation gradients, N_p x 9, row p = F_p row-major.
using Gradients = Eigen::Matrix<double, Eigen::Dynamic, 9, Eigen::RowMajor>;
using GradientsF = Eigen::Matrix<float, Eigen::Dynamic, 9, Eigen::RowMajor>;

/// F_p_res = R_p^T F_p. Throws Error when there is not one rotation a prism.
Gradients residuals_from_gradients(const Eigen::Ref<const Gradients>& gradients,
                                   const std::vector<Eigen::Matrix3d>& prism_rotations);
/// F_p = R_p F_p_res.
Gradients gradients_from_residuals(const Eigen::Ref<const Gradients>& residuals,
                                   const std::vector<Eigen::Matrix3d>& prism_rotations);
/// The same on float32 rows of 9, in place, as networks deliver them.
void rotate_residuals_in_place(float* residuals, const std::vector<Eigen::Matrix3d>& prism_rotations);

}  // namespace ndg
