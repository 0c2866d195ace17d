// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/principal_axes.h"

#include "ndg/core/error.h"
#include "ndg/core/parallel_for.h"
#include "ndg/core/random.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>

namespace ndg {
namespace {

constexpr int spare_axes = 20, num_iterations = 2, rows_at_once = 64;
constexpr Eigen::Index cols_at_once = 4096;
constexpr double smallest_share = 1e-10;  ///< of the first axis' sum of squares; below is rounding

using Range = Eigen::MatrixXd;   ///< columns x axes, sums in double precision
using RangeF = Eigen::MatrixXf;  ///< the same, orthonormal, for products

/// Calls f(first, block) for the rows in turn, `block`: up to rows_at_once x columns.
template <typename F>
void for_blocks(const RowSource& source, const F& f)
{
    RowMatrixF block;
    for (int first = 0; first < source.num_rows; first += rows_at_once) {
        const int count = std::min(rows_at_once, source.num_rows - first);
        block.resize(count, source.num_cols);
        parallel_for(count, [&](int i) { source.row(first + i, block.row(i).data()); });
        f(first, block);
    }
}

/// sums += block^T coefficients.
void add_products(const RowMatrixF& block, const Eigen::MatrixXf& coefficients, Range& sums)
{
    const auto num_chunks = static_cast<int>((sums.rows() + cols_at_once - 1) / cols_at_once);
    parallel_for(num_chunks, [&](int chunk) {
        const Eigen::Index begin = chunk * cols_at_once, count = std::min(cols_at_once, sums.rows() - begin);
        const Eigen::MatrixXf part = block.middleCols(begin, count).transpose() * coefficients;
        sums.middleRows(begin, count) += part.cast<double>();
    });
}

/// Rows' sums over random mixtures of the rows: columns x count.
Range random_mixtures(const RowSource& source, Eigen::Index count, std::uint64_t seed)
{
    Range sums = Range::Zero(source.num_cols, count);
    for_blocks(source, [&](int first, const RowMatrixF& block) {
        Eigen::MatrixXf mix(block.rows(), count);
        for (Eigen::Index i = 0; i < block.rows(); ++i) {
            Random random(seed, "principal axes", static_cast<std::uint64_t>(first + i));
            for (Eigen::Index k = 0; k < count; ++k) mix(i, k) = static_cast<float>(random.normal());
        }
        add_products(block, mix, sums);
    });
    return sums;
}

/// Orthonormal columns with the same span, in the order given, by shifted Cholesky QR (Fukaya et al. 2020) in three
/// rounds. The shifts let columns be dependent; what they then add is rounding, which holds no share of the rows.
RangeF orthonormal(Range columns)
{
    for (Eigen::Index k = 0; k < columns.cols(); ++k) {
        const double norm = columns.col(k).norm();
        if (norm > 0) columns.col(k) /= norm;
    }
    for (int round = 0; round < 3; ++round) {
        Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(columns.cols(), columns.cols());
        gram.selfadjointView<Eigen::Lower>().rankUpdate(columns.transpose());
        gram.diagonal().array() += round == 0 ? 1e-11 : 1e-13;
        const Eigen::LLT<Eigen::MatrixXd> factor(gram.selfadjointView<Eigen::Lower>());
        require(factor.info() == Eigen::Success, "the principal axes were not found: mixtures of rows are dependent");
        factor.matrixU().solveInPlace<Eigen::OnTheRight>(columns);
    }
    return columns.cast<float>();
}

}  // namespace

PrincipalAxes principal_axes(const RowSource& source, int max_axes, double share, std::uint64_t seed)
{
    require(source.num_rows > 0 && max_axes > 0 && share > 0 && share <= 1,
            "{} axes with share {} were asked of {} rows", max_axes, share, source.num_rows);
    const Eigen::Index num_mixtures = std::min<Eigen::Index>({max_axes + spare_axes, source.num_rows, source.num_cols});
    RangeF range = orthonormal(random_mixtures(source, num_mixtures, seed));
    const bool spans_all = num_mixtures == source.num_rows || num_mixtures == source.num_cols;
    for (int i = 0; i < num_iterations && !spans_all; ++i) {
        Range sums = Range::Zero(source.num_cols, num_mixtures);
        for_blocks(source, [&](int, const RowMatrixF& block) { add_products(block, block * range, sums); });
        range = orthonormal(std::move(sums));
    }

    Eigen::MatrixXd moments = Eigen::MatrixXd::Zero(num_mixtures, num_mixtures);
    double sum_of_squares = 0;
    for_blocks(source, [&](int, const RowMatrixF& block) {
        const Eigen::MatrixXd coefficients = (block * range).cast<double>();
        moments.noalias() += coefficients.transpose() * coefficients;
        sum_of_squares += block.cast<double>().squaredNorm();
    });
    require_input(sum_of_squares > 0, "the training samples are all exactly neutral: there is nothing to learn");
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(moments);
    require(solver.info() == Eigen::Success, "the principal axes of {} rows were not found", source.num_rows);
    const Eigen::VectorXd squares = solver.eigenvalues().reverse();
    Eigen::Index count = 0;
    double held = 0;
    while (count < std::min<Eigen::Index>(max_axes, num_mixtures) && squares[count] > smallest_share * squares[0] &&
           (count == 0 || held < share * sum_of_squares))
        held += squares[count++];

    PrincipalAxes result;
    const Eigen::MatrixXf mix = solver.eigenvectors().rowwise().reverse().leftCols(count).cast<float>();
    result.axes = (range * mix).transpose();
    for (Eigen::Index k = 0; k < count; ++k) {
        // Axes have no sign of their own.
        Eigen::Index largest = 0;
        result.axes.row(k).cwiseAbs().maxCoeff(&largest);
        if (result.axes(k, largest) < 0) result.axes.row(k) *= -1;
    }
    result.root_means = (squares.head(count) / source.num_rows).cwiseSqrt();
    result.explained = held / sum_of_squares;
    return result;
}

}  // namespace ndg
