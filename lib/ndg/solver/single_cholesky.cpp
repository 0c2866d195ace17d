// SPDX-License-Identifier: Apache-2.0
#include "ndg/solver/single_cholesky.h"

#include "ndg/core/error.h"
#include "ndg/solver/dense_panels.h"

#include <suitesparse/cholmod.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace ndg {
namespace {

void ignore_message(int, const char*, int, const char*) {}

/// CHOLMOD's workspace and the symbolic factor, for the time of the analysis.
struct Analysis {
    Analysis()
    {
        cholmod_start(&common);
        common.print = 0;
        common.error_handler = ignore_message;
        common.supernodal = CHOLMOD_SUPERNODAL;
        common.final_ll = 1;
    }
    ~Analysis()
    {
        cholmod_free_factor(&factor, &common);
        cholmod_finish(&common);
    }
    Analysis(const Analysis&) = delete;
    Analysis& operator=(const Analysis&) = delete;

    cholmod_common common{};
    cholmod_factor* factor = nullptr;
};

std::size_t at(int i)
{
    return static_cast<std::size_t>(i);
}

}  // namespace

void SingleCholesky::analyze(const Eigen::SparseMatrix<double>& matrix)
{
    if (matrix.rows() != matrix.cols() || !matrix.isCompressed()) {
        throw SolverError(
            fmt::format("a {} x {} matrix to analyse is not square or not compressed", matrix.rows(), matrix.cols()));
    }
    num_unknowns_ = static_cast<int>(matrix.rows());
    num_entries_ = matrix.nonZeros();
    factored_ = false;
    entry_.clear();
    entry_row_.clear();
    entry_column_.clear();
    diagonal_.assign(at(num_unknowns_), -1);
    std::vector<int> starts{0};
    for (int column = 0; column < num_unknowns_; ++column) {
        for (int entry = matrix.outerIndexPtr()[column]; entry < matrix.outerIndexPtr()[column + 1]; ++entry) {
            const int row = matrix.innerIndexPtr()[entry];
            if (row < column) continue;
            if (row == column) diagonal_[at(column)] = entry;
            entry_.push_back(entry);
            entry_row_.push_back(row);
            entry_column_.push_back(column);
        }
        starts.push_back(static_cast<int>(entry_.size()));
        if (diagonal_[at(column)] < 0) throw SolverError(fmt::format("unknown {} has no diagonal entry", column));
    }

    Analysis analysis;
    cholmod_sparse lower{};
    lower.nrow = lower.ncol = at(num_unknowns_);
    lower.nzmax = entry_.size();
    lower.p = starts.data();
    lower.i = entry_row_.data();
    lower.stype = -1;
    lower.itype = CHOLMOD_INT;
    lower.xtype = CHOLMOD_PATTERN;
    lower.dtype = CHOLMOD_DOUBLE;
    lower.sorted = lower.packed = 1;
    analysis.factor = cholmod_analyze(&lower, &analysis.common);
    if (analysis.factor == nullptr || analysis.common.status < CHOLMOD_OK || analysis.factor->is_super == 0) {
        throw SolverError(fmt::format("CHOLMOD could not analyse a matrix of {} unknowns (status {})", num_unknowns_,
                                      analysis.common.status));
    }
    const cholmod_factor& factor = *analysis.factor;
    const auto copy = [](const void* data, std::size_t size) {
        const int* begin = static_cast<const int*>(data);
        return std::vector<int>(begin, begin + size);
    };
    first_column_ = copy(factor.super, factor.nsuper + 1);
    row_begin_ = copy(factor.pi, factor.nsuper + 1);
    rows_ = copy(factor.s, factor.ssize);
    permutation_ = copy(factor.Perm, factor.n);

    const int num_supernodes = static_cast<int>(factor.nsuper);
    supernode_of_.resize(at(num_unknowns_));
    value_begin_.assign(1, 0);
    for (int s = 0; s < num_supernodes; ++s) {
        const int columns = first_column_[at(s) + 1] - first_column_[at(s)];
        const int rows = row_begin_[at(s) + 1] - row_begin_[at(s)];
        std::fill_n(supernode_of_.begin() + first_column_[at(s)], columns, s);
        value_begin_.push_back(value_begin_.back() + at(columns) * at(rows));
    }
    std::vector<int> position_of(at(num_unknowns_));
    for (int i = 0; i < num_unknowns_; ++i) position_of[at(permutation_[at(i)])] = i;
    place_.resize(entry_.size());
    for (std::size_t k = 0; k < entry_.size(); ++k) {
        const int a = position_of[at(entry_row_[k])], b = position_of[at(entry_column_[k])];
        const int column = std::min(a, b), row = std::max(a, b);
        const int s = supernode_of_[at(column)];
        const auto begin = rows_.begin() + row_begin_[at(s)], end = rows_.begin() + row_begin_[at(s) + 1];
        const auto local_row = at(static_cast<int>(std::lower_bound(begin, end, row) - begin));
        place_[k] =
            value_begin_[at(s)] + at(column - first_column_[at(s)]) * at(static_cast<int>(end - begin)) + local_row;
    }
    values_.resize(value_begin_.back() + dense_panel_padding);
    head_.resize(at(num_supernodes));
    next_.resize(at(num_supernodes));
    position_.resize(at(num_supernodes));
    local_row_.resize(at(num_unknowns_));
    target_row_.resize(at(num_unknowns_));
}

bool SingleCholesky::factorize(const Eigen::SparseMatrix<double>& matrix)
{
    factored_ = false;
    if (matrix.rows() != num_unknowns_ || matrix.nonZeros() != num_entries_ || num_unknowns_ == 0) {
        throw SolverError("the matrix to factorise has another pattern than the analysed");
    }
    scale_.resize(num_unknowns_);
    for (int i = 0; i < num_unknowns_; ++i) {
        const double diagonal = matrix.valuePtr()[diagonal_[at(i)]];
        if (!std::isfinite(diagonal)) throw SolverError("the matrix to factorise has a non-finite value");
        if (!(diagonal > 0)) return false;
        scale_(i) = 1 / std::sqrt(diagonal);
    }
    std::fill(values_.begin(), values_.end(), 0.0F);
    double sum = 0;
    for (std::size_t k = 0; k < entry_.size(); ++k) {
        const double value = matrix.valuePtr()[entry_[k]] * scale_(entry_row_[k]) * scale_(entry_column_[k]);
        sum += value;
        values_[place_[k]] = static_cast<float>(value);
    }
    if (!std::isfinite(sum)) throw SolverError("the matrix to factorise has a non-finite value");

    const int num_supernodes = static_cast<int>(head_.size());
    std::fill(head_.begin(), head_.end(), -1);
    for (int s = 0; s < num_supernodes; ++s) {
        const int columns = first_column_[at(s) + 1] - first_column_[at(s)];
        const int rows = row_begin_[at(s) + 1] - row_begin_[at(s)];
        const int* row_idx = rows_.data() + row_begin_[at(s)];
        float* block = values_.data() + value_begin_[at(s)];
        for (int i = 0; i < rows; ++i) local_row_[at(row_idx[i])] = i;

        for (int d = head_[at(s)]; d >= 0;) {
            const int following = next_[at(d)];
            const int d_columns = first_column_[at(d) + 1] - first_column_[at(d)];
            const int d_rows = row_begin_[at(d) + 1] - row_begin_[at(d)];
            const int* d_idx = rows_.data() + row_begin_[at(d)];
            const int begin = position_[at(d)];
            int end = begin;
            while (end < d_rows && d_idx[end] < first_column_[at(s) + 1]) ++end;
            const int width = end - begin, height = d_rows - begin, below = d_rows - end;
            for (int i = 0; i < height; ++i) target_row_[at(i)] = local_row_[at(d_idx[begin + i])];
            DenseUpdate update;
            update.a = values_.data() + value_begin_[at(d)] + begin;
            update.stride = at(d_rows);
            update.depth = d_columns;
            update.height = height;
            update.width = width;
            subtract_scattered(update, block, at(rows), target_row_.data());
            if (below > 0) {
                const int target = supernode_of_[at(d_idx[end])];
                position_[at(d)] = end;
                next_[at(d)] = head_[at(target)];
                head_[at(target)] = d;
            }
            d = following;
        }

        if (!factorize_panel(block, columns, rows)) return false;
        if (columns < rows) {
            const int target = supernode_of_[at(row_idx[columns])];
            position_[at(s)] = columns;
            next_[at(s)] = head_[at(target)];
            head_[at(target)] = s;
        }
    }
    factored_ = true;
    return true;
}

void SingleCholesky::solve(const Eigen::VectorXd& right_hand_side, Eigen::VectorXd& solution)
{
    if (!factored_ || right_hand_side.size() != num_unknowns_) {
        throw SolverError(fmt::format("no factor for a right-hand side of {} unknowns", right_hand_side.size()));
    }
    work_.resize(at(num_unknowns_));
    for (int i = 0; i < num_unknowns_; ++i) {
        const int unknown = permutation_[at(i)];
        work_[at(i)] = static_cast<float>(right_hand_side(unknown) * scale_(unknown));
    }
    const int num_supernodes = static_cast<int>(head_.size());
    const auto visit = [&](int s, bool forward) {
        const int first = first_column_[at(s)], columns = first_column_[at(s) + 1] - first;
        const int rows = row_begin_[at(s) + 1] - row_begin_[at(s)], below = rows - columns;
        const int* row_idx = rows_.data() + row_begin_[at(s)] + columns;
        const float* block = values_.data() + value_begin_[at(s)];
        block_work_.resize(std::max(block_work_.size(), at(rows)));
        float* x = block_work_.data();
        std::copy_n(work_.data() + first, columns, x);
        if (forward) {
            std::fill_n(x + columns, below, 0.0F);
            substitute_forward(block, columns, rows, x);
            for (int i = 0; i < below; ++i) work_[at(row_idx[i])] += x[columns + i];
        } else {
            for (int i = 0; i < below; ++i) x[columns + i] = work_[at(row_idx[i])];
            substitute_backward(block, columns, rows, x);
        }
        std::copy_n(x, columns, work_.data() + first);
    };
    for (int s = 0; s < num_supernodes; ++s) visit(s, true);
    for (int s = num_supernodes - 1; s >= 0; --s) visit(s, false);
    solution.resize(num_unknowns_);
    for (int i = 0; i < num_unknowns_; ++i) {
        const int unknown = permutation_[at(i)];
        solution(unknown) = static_cast<double>(work_[at(i)]) * scale_(unknown);
    }
}

}  // namespace ndg
