// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/output_basis.h"

#include "ndg/core/error.h"
#include "ndg/core/random.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace ndg {
namespace {

constexpr int max_basis_samples = 1000;
constexpr double smallest_stretch = 0.05;

using Matrix3fRow = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;

}  // namespace

void residual_logarithm(const float* residual, bool exponential, float* logarithm)
{
    const Eigen::Matrix3d gradient = Eigen::Map<const Matrix3fRow>(residual).cast<double>();
    Eigen::Map<Matrix3fRow> target(logarithm);
    if (!exponential) {
        target = (gradient - Eigen::Matrix3d::Identity()).cast<float>();
        return;
    }
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(gradient, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d u = svd.matrixU();
    const Eigen::Matrix3d& v = svd.matrixV();
    Eigen::Vector3d stretches = svd.singularValues();
    if ((u * v.transpose()).determinant() < 0) {
        u.col(2) *= -1;
        stretches[2] *= -1;
    }
    stretches = stretches.cwiseMax(smallest_stretch);
    const Eigen::AngleAxisd rotation{Eigen::Matrix3d(u * v.transpose())};
    const Eigen::Vector3d axis = rotation.angle() * rotation.axis();
    Eigen::Matrix3d log_rotation;
    log_rotation << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
    target = (log_rotation + v * stretches.array().log().matrix().asDiagonal() * v.transpose()).cast<float>();
}

RowMatrixF fit_output_basis(const TrainingSet& set, int num_components, bool exponential, std::uint64_t seed)
{
    std::vector<int> chosen(static_cast<std::size_t>(set.size()));
    std::iota(chosen.begin(), chosen.end(), 0);
    if (set.size() > max_basis_samples) {
        chosen = Random(seed, "output basis").permutation(set.size());
        chosen.resize(max_basis_samples);
    }
    const auto num_samples = static_cast<Eigen::Index>(chosen.size());
    RowMatrixF logarithms(num_samples, 9 * static_cast<Eigen::Index>(set.num_prisms()));
#pragma omp parallel for schedule(static)
    for (Eigen::Index i = 0; i < num_samples; ++i) {
        std::vector<float> residuals(static_cast<std::size_t>(logarithms.cols()));
        set.residuals(chosen[static_cast<std::size_t>(i)], residuals.data());
        for (Eigen::Index p = 0; p < set.num_prisms(); ++p)
            residual_logarithm(residuals.data() + 9 * p, exponential,
                               logarithms.data() + i * logarithms.cols() + 9 * p);
    }
    // Method of snapshots: the axes are combinations of the samples. Summed in double precision over blocks of columns.
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(num_samples, num_samples);
    constexpr Eigen::Index block = 4096;
    for (Eigen::Index begin = 0; begin < logarithms.cols(); begin += block) {
        const Eigen::Index count = std::min(block, logarithms.cols() - begin);
        const Eigen::MatrixXd part = logarithms.middleCols(begin, count).cast<double>();
        gram.noalias() += part * part.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(gram);
    require(solver.info() == Eigen::Success, "the principal components of {} training residuals were not found",
            num_samples);
    const double largest = solver.eigenvalues()[num_samples - 1];
    require_input(largest > 0, "the training residuals are all exactly zero: there is nothing to learn");
    Eigen::Index rank = 0;
    while (rank < std::min<Eigen::Index>(num_components, num_samples) &&
           solver.eigenvalues()[num_samples - 1 - rank] > 1e-10 * largest)
        ++rank;
    RowMatrixF basis(rank, logarithms.cols());
    for (Eigen::Index k = 0; k < rank; ++k) {
        // Unit axis = A^T v / sigma; typical coefficient = sigma / sqrt(n).
        Eigen::VectorXf mix =
            (solver.eigenvectors().col(num_samples - 1 - k) / std::sqrt(static_cast<double>(num_samples)))
                .cast<float>();
        Eigen::Index strongest = 0;
        mix.cwiseAbs().maxCoeff(&strongest);
        if (mix[strongest] < 0) mix = -mix;  // eigenvectors have no sign of their own
        basis.row(k) = mix.transpose() * logarithms;
    }
    return basis;
}

}  // namespace ndg
