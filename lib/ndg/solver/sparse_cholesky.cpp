// SPDX-License-Identifier: Apache-2.0
#include "ndg/solver/sparse_cholesky.h"

#include "ndg/core/error.h"

#include <suitesparse/cholmod.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace ndg {
namespace {

/// CHOLMOD reports through its status, which is checked after every call.
void ignore_message(int, const char*, int, const char*) {}

}  // namespace

struct SparseCholesky::State {
    explicit State(Method method)
    {
        cholmod_start(&common);
        common.print = 0;
        common.error_handler = ignore_message;
        common.quick_return_if_not_posdef = 1;
        if (method == Method::simplicial) common.supernodal = CHOLMOD_SIMPLICIAL;
        if (method == Method::supernodal) common.supernodal = CHOLMOD_SUPERNODAL;
        // L L^T for both kinds: an indefinite matrix then stops the simplicial factorisation too (L D L^T would not).
        common.final_ll = 1;
    }
    State(const State&) = delete;
    State& operator=(const State&) = delete;
    ~State()
    {
        cholmod_free_dense(&solution, &common);
        cholmod_free_dense(&forward_work, &common);
        cholmod_free_dense(&backward_work, &common);
        cholmod_free_factor(&factor, &common);
        cholmod_finish(&common);
    }

    /// The lower triangle as CHOLMOD sees it; the arrays belong to this object.
    cholmod_sparse lower_view()
    {
        cholmod_sparse view{};
        view.nrow = view.ncol = static_cast<std::size_t>(num_unknowns);
        view.nzmax = lower_rows.size();
        view.p = lower_starts.data();
        view.i = lower_rows.data();
        view.x = lower_values.data();
        view.stype = -1;
        view.itype = CHOLMOD_INT;
        view.xtype = CHOLMOD_REAL;
        view.dtype = CHOLMOD_DOUBLE;
        view.sorted = 1;
        view.packed = 1;
        return view;
    }

    bool same_pattern(const Eigen::SparseMatrix<double>& matrix) const
    {
        return matrix.rows() == num_unknowns && matrix.cols() == num_unknowns && matrix.isCompressed() &&
               matrix.nonZeros() == static_cast<Eigen::Index>(full_rows.size()) &&
               std::equal(full_starts.begin(), full_starts.end(), matrix.outerIndexPtr()) &&
               std::equal(full_rows.begin(), full_rows.end(), matrix.innerIndexPtr());
    }

    cholmod_common common{};
    cholmod_factor* factor = nullptr;
    bool factorized = false;

    Eigen::Index num_unknowns = 0;
    std::vector<int> full_starts, full_rows;    ///< pattern of the analysed matrix, to recognise it again
    std::vector<int> lower_starts, lower_rows;  ///< pattern of its lower triangle
    std::vector<int> lower_from_full;           ///< entry of the analysed matrix that each lower entry is copied from
    std::vector<double> lower_values;

    // Kept by cholmod_solve2 from one solve to the next.
    cholmod_dense* solution = nullptr;
    cholmod_dense* forward_work = nullptr;
    cholmod_dense* backward_work = nullptr;
};

SparseCholesky::SparseCholesky(Method method) : state_(std::make_unique<State>(method)) {}
SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

void SparseCholesky::analyze(const Eigen::SparseMatrix<double>& matrix)
{
    if (matrix.rows() != matrix.cols()) {
        throw SolverError(fmt::format("a {} x {} matrix is not square", matrix.rows(), matrix.cols()));
    }
    if (!matrix.isCompressed()) throw SolverError("the matrix to analyse is not compressed");
    State& state = *state_;
    const int size = static_cast<int>(matrix.rows());
    const int* starts = matrix.outerIndexPtr();
    const int* rows = matrix.innerIndexPtr();
    state.num_unknowns = size;
    state.full_starts.assign(starts, starts + size + 1);
    state.full_rows.assign(rows, rows + matrix.nonZeros());
    state.lower_starts.assign(1, 0);
    state.lower_rows.clear();
    state.lower_from_full.clear();
    for (int column = 0; column < size; ++column) {
        for (int entry = starts[column]; entry < starts[column + 1]; ++entry) {
            if (rows[entry] < column) continue;
            state.lower_rows.push_back(rows[entry]);
            state.lower_from_full.push_back(entry);
        }
        state.lower_starts.push_back(static_cast<int>(state.lower_rows.size()));
    }
    state.lower_values.assign(state.lower_rows.size(), 0.0);

    state.factorized = false;
    cholmod_free_factor(&state.factor, &state.common);
    cholmod_sparse lower = state.lower_view();
    state.factor = cholmod_analyze(&lower, &state.common);
    if (state.factor == nullptr || state.common.status < CHOLMOD_OK) {
        throw SolverError(
            fmt::format("CHOLMOD could not analyse a matrix of {} unknowns (status {})", size, state.common.status));
    }
}

bool SparseCholesky::factorize(const Eigen::SparseMatrix<double>& matrix)
{
    State& state = *state_;
    state.factorized = false;
    if (state.factor == nullptr) throw SolverError("factorize was called before analyze");
    if (!state.same_pattern(matrix)) throw SolverError("the matrix to factorise has another pattern than the analysed");
    const double* values = matrix.valuePtr();
    for (std::size_t entry = 0; entry < state.lower_values.size(); ++entry) {
        state.lower_values[entry] = values[state.lower_from_full[entry]];
    }
    for (const double value : state.lower_values) {
        if (!std::isfinite(value)) throw SolverError("the matrix to factorise has a non-finite value");
    }
    cholmod_sparse lower = state.lower_view();
    cholmod_factorize(&lower, state.factor, &state.common);
    const int status = state.common.status;
    if (status == CHOLMOD_NOT_POSDEF) return false;
    if (status < CHOLMOD_OK) {
        throw SolverError(
            fmt::format("CHOLMOD could not factorise a matrix of {} unknowns (status {})", state.num_unknowns, status));
    }
    if (status == CHOLMOD_DSMALL || state.factor->minor < state.factor->n) return false;
    state.factorized = true;
    return true;
}

Eigen::MatrixXd SparseCholesky::solve(const Eigen::Ref<const Eigen::MatrixXd>& right_hand_side) const
{
    State& state = *state_;
    if (!state.factorized) throw SolverError("solve was called without a factorisation");
    if (right_hand_side.rows() != state.num_unknowns) {
        throw SolverError(fmt::format("the right-hand side has {} rows, the system {} unknowns", right_hand_side.rows(),
                                      state.num_unknowns));
    }
    if (!right_hand_side.allFinite()) throw SolverError("the right-hand side has a non-finite value");
    if (right_hand_side.size() == 0) return right_hand_side;

    cholmod_dense input{};
    input.nrow = static_cast<std::size_t>(right_hand_side.rows());
    input.ncol = static_cast<std::size_t>(right_hand_side.cols());
    input.d = static_cast<std::size_t>(right_hand_side.outerStride());
    input.nzmax = input.d * input.ncol;
    input.x = const_cast<double*>(right_hand_side.data());  // CHOLMOD only reads it
    input.xtype = CHOLMOD_REAL;
    input.dtype = CHOLMOD_DOUBLE;
    if (cholmod_solve2(CHOLMOD_A, state.factor, &input, nullptr, &state.solution, nullptr, &state.forward_work,
                       &state.backward_work, &state.common) == 0) {
        throw SolverError(fmt::format("CHOLMOD could not solve (status {})", state.common.status));
    }
    return Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>(
        static_cast<const double*>(state.solution->x), right_hand_side.rows(), right_hand_side.cols(),
        Eigen::OuterStride<>(static_cast<Eigen::Index>(state.solution->d)));
}

double SparseCholesky::factor_nonzeros() const
{
    const State& state = *state_;
    if (state.factor == nullptr) return 0.0;
    if (state.factor->is_super != 0) {
        // Supernodes store dense blocks; count those blocks' lower parts.
        const auto* first = static_cast<const int*>(state.factor->super);
        const auto* row_starts = static_cast<const int*>(state.factor->pi);
        double count = 0.0;
        for (std::size_t s = 0; s < state.factor->nsuper; ++s) {
            const double columns = first[s + 1] - first[s];
            const double rows = row_starts[s + 1] - row_starts[s];
            count += columns * rows - 0.5 * columns * (columns - 1.0);
        }
        return count;
    }
    const auto* column_counts = static_cast<const int*>(state.factor->ColCount);
    double count = 0.0;
    for (std::size_t column = 0; column < state.factor->n; ++column) count += column_counts[column];
    return count;
}

}  // namespace ndg
