// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/residuals.h"

#include "ndg/core/error.h"

namespace ndg {

namespace {

using Matrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Matrix3f = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;

void require_same_size(Eigen::Index rows, std::size_t rotations)
{
    require(rows == static_cast<Eigen::Index>(rotations), "{} deformation gradients but {} prism rotations", rows,
            rotations);
}

}  // namespace

Gradients residuals_from_gradients(const Eigen::Ref<const Gradients>& gradients,
                                   const std::vector<Eigen::Matrix3d>& prism_rotations)
{
    require_same_size(gradients.rows(), prism_rotations.size());
    Gradients residuals(gradients.rows(), 9);
    for (Eigen::Index p = 0; p < gradients.rows(); ++p) {
        const Eigen::Map<const Matrix3> gradient(gradients.row(p).data());
        Eigen::Map<Matrix3> residual(residuals.row(p).data());
        residual.noalias() = prism_rotations[p].transpose() * gradient;
    }
    return residuals;
}

Gradients gradients_from_residuals(const Eigen::Ref<const Gradients>& residuals,
                                   const std::vector<Eigen::Matrix3d>& prism_rotations)
{
    require_same_size(residuals.rows(), prism_rotations.size());
    Gradients gradients(residuals.rows(), 9);
    for (Eigen::Index p = 0; p < residuals.rows(); ++p) {
        const Eigen::Map<const Matrix3> residual(residuals.row(p).data());
        Eigen::Map<Matrix3> gradient(gradients.row(p).data());
        gradient.noalias() = prism_rotations[p] * residual;
    }
    return gradients;
}

void rotate_residuals_in_place(float* residuals, const std::vector<Eigen::Matrix3d>& prism_rotations)
{
    for (std::size_t p = 0; p < prism_rotations.size(); ++p) {
        Eigen::Map<Matrix3f> block(residuals + 9 * p);
        const Matrix3f gradient = prism_rotations[p].cast<float>() * block;
        block = gradient;
    }
}

}  // namespace ndg
