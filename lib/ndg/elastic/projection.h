// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

namespace ndg {

/// Nearest positive semi-definite matrix in the Frobenius norm: negative eigenvalues set to zero (Teran et al. 2005).
template <int Size>
Eigen::Matrix<double, Size, Size> clamp_eigenvalues(const Eigen::Matrix<double, Size, Size>& symmetric)
{
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, Size, Size>> solver(symmetric);
    if (solver.eigenvalues()(0) >= 0) return symmetric;
    const Eigen::Matrix<double, Size, Size> scaled =
        solver.eigenvectors() * solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
    return scaled.lazyProduct(scaled.transpose());
}

}  // namespace ndg
