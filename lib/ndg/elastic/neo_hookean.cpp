// SPDX-License-Identifier: Apache-2.0
#include "ndg/elastic/neo_hookean.h"

#include <Eigen/Dense>

#include <cmath>

namespace ndg {

namespace {

Eigen::Matrix3d cofactor(const Eigen::Matrix3d& f)
{
    Eigen::Matrix3d cofactors;
    cofactors.col(0) = f.col(1).cross(f.col(2));
    cofactors.col(1) = f.col(2).cross(f.col(0));
    cofactors.col(2) = f.col(0).cross(f.col(1));
    return cofactors;
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v)
{
    Eigen::Matrix3d m;
    m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
    return m;
}

}  // namespace

double neo_hookean_energy(const Eigen::Matrix3d& deformation, const Lame& lame)
{
    // Expanded around J = 1, so that the large constant lambda/2 (1 - alpha)^2 cancels exactly.
    const double dilation = deformation.determinant() - 1;
    return 0.5 * lame.mu * (deformation.squaredNorm() - 3) - lame.mu * dilation +
           0.5 * lame.lambda * dilation * dilation;
}

Eigen::Matrix3d neo_hookean_stress(const Eigen::Matrix3d& deformation, const Lame& lame)
{
    const double pressure = lame.lambda * (deformation.determinant() - 1) - lame.mu;
    return lame.mu * deformation + pressure * cofactor(deformation);
}

Matrix9 neo_hookean_hessian(const Eigen::Matrix3d& deformation, const Lame& lame)
{
    const double pressure = lame.lambda * (deformation.determinant() - 1) - lame.mu;
    const Eigen::Matrix3d cofactors = cofactor(deformation);
    const Eigen::Map<const Eigen::Matrix<double, 9, 1>> volume_gradient(cofactors.data());
    Matrix9 hessian = lame.lambda * volume_gradient * volume_gradient.transpose();
    hessian.diagonal().array() += lame.mu;
    for (int column = 0; column < 3; ++column) {
        // d^2 J couples every two columns of F through the third.
        const Eigen::Matrix3d cross = pressure * cross_matrix(deformation.col(column));
        const int next = (column + 1) % 3, previous = (column + 2) % 3;
        hessian.block<3, 3>(3 * next, 3 * previous) -= cross;
        hessian.block<3, 3>(3 * previous, 3 * next) += cross;
    }
    return hessian;
}

double neo_hookean_stability(const Eigen::Matrix3d& deformation, const Lame& lame)
{
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    solver.computeDirect(deformation.transpose() * deformation, Eigen::EigenvaluesOnly);
    const double largest = std::sqrt(std::max(solver.eigenvalues()(2), 0.0));
    const double pressure = lame.lambda * (deformation.determinant() - 1) - lame.mu;
    return 1 - std::abs(pressure) * largest / lame.mu;
}

Matrix9 neo_hookean_projected_modes(const Eigen::Matrix3d& deformation, const Lame& lame)
{
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(deformation, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Vector3d s = svd.singularValues();
    Eigen::Matrix3d u = svd.matrixU();
    // Signed singular values make det F = s0 s1 s2; a reflected U V^T goes into the smallest one.
    if (u.determinant() * svd.matrixV().determinant() < 0) {
        u.col(2) = -u.col(2);
        s(2) = -s(2);
    }
    const Eigen::Matrix3d v = svd.matrixV();
    const double volume = s(0) * s(1) * s(2);
    const double pressure = lame.lambda * (volume - 1) - lame.mu;

    // u_i v_j^T as 9-vectors.
    Matrix9 dyads;
    for (int j = 0; j < 3; ++j) {
        for (int i = 0; i < 3; ++i) {
            Eigen::Map<Eigen::Matrix3d>(dyads.col(i + 3 * j).data()) = u.col(i) * v.col(j).transpose();
        }
    }

    Matrix9 scaled_modes;  // eigenvectors times the root of their clamped eigenvalues
    int mode = 0;
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const double twist = std::sqrt(0.5 * std::max(lame.mu + pressure * s(k), 0.0));
        const double flip = std::sqrt(0.5 * std::max(lame.mu - pressure * s(k), 0.0));
        scaled_modes.col(mode++) = twist * (dyads.col(j + 3 * i) - dyads.col(i + 3 * j));
        scaled_modes.col(mode++) = flip * (dyads.col(j + 3 * i) + dyads.col(i + 3 * j));
    }
    Eigen::Matrix3d stretch;
    for (int i = 0; i < 3; ++i) {
        const double area = s((i + 1) % 3) * s((i + 2) % 3);
        stretch(i, i) = lame.mu + lame.lambda * area * area;
    }
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        stretch(i, j) = stretch(j, i) = s(k) * (lame.lambda * volume + pressure);
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(stretch);
    for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d axis = std::sqrt(std::max(solver.eigenvalues()(k), 0.0)) * solver.eigenvectors().col(k);
        scaled_modes.col(mode++) = axis(0) * dyads.col(0) + axis(1) * dyads.col(4) + axis(2) * dyads.col(8);
    }
    return scaled_modes;
}

Matrix9 neo_hookean_projected_hessian(const Eigen::Matrix3d& deformation, const Lame& lame)
{
    const Matrix9 modes = neo_hookean_projected_modes(deformation, lame);
    return modes.lazyProduct(modes.transpose());
}

}  // namespace ndg
