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

/// The columns of rows of which axes are looked for.
struct Block {
    const std::vector<int>* columns = nullptr;  ///< null: all
    Eigen::Index num_cols = 0, num_mixtures = 0;
    Range sums;
    RangeF range;  ///< num_cols x num_mixtures, orthonormal
    Eigen::MatrixXd moments;
    double sum_of_squares = 0;
    RowMatrixF selected;

    const RowMatrixF& select(const RowMatrixF& rows)
    {
        if (!columns) return rows;
        selected.resize(rows.rows(), num_cols);
        for (Eigen::Index i = 0; i < rows.rows(); ++i)
            for (Eigen::Index k = 0; k < num_cols; ++k) selected(i, k) = rows(i, (*columns)[k]);
        return selected;
    }
};

/// Calls f(block, first, rows) for the block's columns of all rows in turn, up to rows_at_once of them.
template <typename F>
void for_rows(const RowSource& source, std::vector<Block>& blocks, const F& f)
{
    RowMatrixF rows;
    for (int first = 0; first < source.num_rows; first += rows_at_once) {
        const int count = std::min(rows_at_once, source.num_rows - first);
        rows.resize(count, source.num_cols);
        parallel_for(count, [&](int i) { source.row(first + i, rows.row(i).data()); });
        if (blocks.size() == 1)
            f(blocks[0], first, blocks[0].select(rows));  // which may share its work among threads
        else
            parallel_for(static_cast<int>(blocks.size()), [&](int i) { f(blocks[i], first, blocks[i].select(rows)); });
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

/// Mixtures of rows from `first` on, num_rows x count: the same for a row whatever else is asked for.
Eigen::MatrixXf random_mix(int first, Eigen::Index num_rows, Eigen::Index count, std::uint64_t seed)
{
    Eigen::MatrixXf mix(num_rows, count);
    for (Eigen::Index i = 0; i < num_rows; ++i) {
        Random random(seed, "principal axes", static_cast<std::uint64_t>(first + i));
        for (Eigen::Index k = 0; k < count; ++k) mix(i, k) = static_cast<float>(random.normal());
    }
    return mix;
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

/// The axes of a block whose moments are known.
PrincipalAxes leading_axes(const Block& block, int num_rows, int max_axes, double share)
{
    require_input(block.sum_of_squares > 0, "the training samples are all exactly neutral: there is nothing to learn");
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(block.moments);
    require(solver.info() == Eigen::Success, "the principal axes of {} rows were not found", num_rows);
    const Eigen::VectorXd squares = solver.eigenvalues().reverse();
    Eigen::Index count = 0;
    double held = 0;
    while (count < std::min<Eigen::Index>(max_axes, block.num_mixtures) &&
           squares[count] > smallest_share * squares[0] && (count == 0 || held < share * block.sum_of_squares))
        held += squares[count++];

    PrincipalAxes result;
    const Eigen::MatrixXf mix = solver.eigenvectors().rowwise().reverse().leftCols(count).cast<float>();
    result.axes = (block.range * mix).transpose();
    for (Eigen::Index k = 0; k < count; ++k) {
        // Axes have no sign of their own.
        Eigen::Index largest = 0;
        result.axes.row(k).cwiseAbs().maxCoeff(&largest);
        if (result.axes(k, largest) < 0) result.axes.row(k) *= -1;
    }
    result.root_means = (squares.head(count) / num_rows).cwiseSqrt();
    result.explained = held / block.sum_of_squares;
    return result;
}

std::vector<PrincipalAxes> find_axes(const RowSource& source, std::vector<Block> blocks, int max_axes, double share,
                                     std::uint64_t seed)
{
    require(source.num_rows > 0 && max_axes > 0 && share > 0 && share <= 1,
            "{} axes with share {} were asked of {} rows", max_axes, share, source.num_rows);
    const auto begin_sums = [&] {
        for (Block& block : blocks) block.sums = Range::Zero(block.num_cols, block.num_mixtures);
    };
    const auto end_sums = [&] {
        for (Block& block : blocks) block.range = orthonormal(std::move(block.sums));
    };
    bool all_spanned = true;
    for (Block& block : blocks) {
        block.num_mixtures = std::min<Eigen::Index>({max_axes + spare_axes, source.num_rows, block.num_cols});
        all_spanned &= block.num_mixtures == source.num_rows || block.num_mixtures == block.num_cols;
    }
    begin_sums();
    for_rows(source, blocks, [&](Block& block, int first, const RowMatrixF& rows) {
        add_products(rows, random_mix(first, rows.rows(), block.num_mixtures, seed), block.sums);
    });
    end_sums();
    for (int i = 0; i < num_iterations && !all_spanned; ++i) {
        begin_sums();
        for_rows(source, blocks, [&](Block& block, int, const RowMatrixF& rows) {
            add_products(rows, rows * block.range, block.sums);
        });
        end_sums();
    }
    for (Block& block : blocks) block.moments = Eigen::MatrixXd::Zero(block.num_mixtures, block.num_mixtures);
    for_rows(source, blocks, [&](Block& block, int, const RowMatrixF& rows) {
        const Eigen::MatrixXd coefficients = (rows * block.range).cast<double>();
        block.moments.noalias() += coefficients.transpose() * coefficients;
        block.sum_of_squares += rows.cast<double>().squaredNorm();
    });
    std::vector<PrincipalAxes> axes;
    for (const Block& block : blocks) axes.push_back(leading_axes(block, source.num_rows, max_axes, share));
    return axes;
}

}  // namespace

PrincipalAxes principal_axes(const RowSource& source, int max_axes, double share, std::uint64_t seed)
{
    std::vector<Block> all(1);
    all[0].num_cols = source.num_cols;
    return find_axes(source, std::move(all), max_axes, share, seed).front();
}

std::vector<PrincipalAxes> principal_axes(const RowSource& source, const std::vector<std::vector<int>>& blocks,
                                          int max_axes, double share, std::uint64_t seed)
{
    std::vector<Block> some;
    for (const std::vector<int>& columns : blocks) {
        Block& block = some.emplace_back();
        block.columns = &columns;
        block.num_cols = static_cast<Eigen::Index>(columns.size());
    }
    return find_axes(source, std::move(some), max_axes, share, seed);
}

}  // namespace ndg
