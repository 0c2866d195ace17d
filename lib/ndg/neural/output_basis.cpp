// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/output_basis.h"

#include "ndg/core/error.h"
#include "ndg/core/parallel_for.h"
#include "ndg/core/random.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace ndg {
namespace {

constexpr int max_basis_samples = 1000;

}  // namespace

RowMatrixF fit_output_basis(const TrainingSet& set, const OutputSpace& output_space, int num_components,
                            std::uint64_t seed)
{
    std::vector<int> chosen(set.size());
    std::iota(chosen.begin(), chosen.end(), 0);
    if (set.size() > max_basis_samples) {
        chosen = Random(seed, "output basis").permutation(set.size());
        chosen.resize(max_basis_samples);
    }
    const auto num_samples = static_cast<Eigen::Index>(chosen.size());
    RowMatrixF outputs(num_samples, output_space.width());
    parallel_for(static_cast<int>(num_samples), [&](int i) {
        std::vector<float> target(outputs.cols());
        set.target(chosen[i], target.data());
        output_space.approximate_inverse(target.data(), outputs.row(i).data());
    });
    // Method of snapshots: the axes are combinations of the samples. Summed in double precision over blocks of columns.
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(num_samples, num_samples);
    constexpr Eigen::Index block = 4096;
    for (Eigen::Index begin = 0; begin < outputs.cols(); begin += block) {
        const Eigen::Index count = std::min(block, outputs.cols() - begin);
        const Eigen::MatrixXd part = outputs.middleCols(begin, count).cast<double>();
        gram.noalias() += part * part.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(gram);
    require(solver.info() == Eigen::Success, "the principal components of {} training samples were not found",
            num_samples);
    const double largest = solver.eigenvalues()[num_samples - 1];
    require_input(largest > 0, "the training samples are all exactly neutral: there is nothing to learn");
    Eigen::Index rank = 0;
    while (rank < std::min<Eigen::Index>(num_components, num_samples) &&
           solver.eigenvalues()[num_samples - 1 - rank] > 1e-10 * largest)
        ++rank;
    RowMatrixF basis(rank, outputs.cols());
    for (Eigen::Index k = 0; k < rank; ++k) {
        // Unit axis = A^T v / sigma; typical coefficient = sigma / sqrt(n).
        Eigen::VectorXf mix =
            (solver.eigenvectors().col(num_samples - 1 - k) / std::sqrt(static_cast<double>(num_samples)))
                .cast<float>();
        Eigen::Index strongest = 0;
        mix.cwiseAbs().maxCoeff(&strongest);
        if (mix[strongest] < 0) mix = -mix;  // eigenvectors have no sign of their own
        basis.row(k) = mix.transpose() * outputs;
    }
    return basis;
}

}  // namespace ndg
