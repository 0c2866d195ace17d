// SPDX-License-Identifier: Apache-2.0
// Sparse Cholesky factorisation in single precision, a preconditioner for systems solved in double: half the memory
// traffic and half the time of a double one. CHOLMOD orders and analyses; its release in Debian 12 factors in double
// only, so the numeric part is here (supernodal, left-looking; Ng and Peyton 1993; Chen et al. 2008).
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <vector>

namespace ndg {

/// Analyse once, factor often while the pattern stays. One object per thread.
class SingleCholesky {
public:
    /// Orders and analyses the pattern of a symmetric matrix; only the lower triangle of `matrix` is read (it may hold
    /// the full matrix). Must be compressed. Throws SolverError for a matrix that is not square.
    void analyze(const Eigen::SparseMatrix<double>& matrix);
    /// Numeric factorisation of a matrix with the analysed pattern, rounded to single precision and scaled to a unit
    /// diagonal. False when it is not positive definite, as far as single precision can tell. Throws SolverError for
    /// non-finite values or another number of non-zeros.
    bool factorize(const Eigen::SparseMatrix<double>& matrix);
    /// Approximate solution, to about single precision times the condition number.
    void solve(const Eigen::VectorXd& right_hand_side, Eigen::VectorXd& solution);
    /// Non-zeros of the factor, with those stored in its dense blocks.
    std::size_t factor_nonzeros() const { return value_begin_.back(); }

private:
    int num_unknowns_ = 0;
    std::vector<int> first_column_;              ///< of every supernode, and n
    std::vector<int> supernode_of_;              ///< column -> supernode
    std::vector<int> row_begin_, rows_;          ///< row indices of every supernode
    std::vector<std::size_t> value_begin_{0};    ///< its dense block, column by column
    std::vector<int> permutation_;               ///< position in the factor -> unknown
    std::vector<int> entry_;                     ///< entries of the matrix that are read
    std::vector<std::size_t> place_;             ///< where each goes
    std::vector<int> entry_row_, entry_column_;  ///< of the matrix
    Eigen::Index num_entries_ = 0;
    std::vector<int> diagonal_;  ///< entry of each unknown's diagonal

    bool factored_ = false;
    std::vector<float> values_, work_, block_work_;
    Eigen::VectorXd scale_;
    // Of the factorisation: supernodes waiting to update supernode s form a list; how far each has got; local rows.
    std::vector<int> head_, next_, position_, local_row_, target_row_;
};

}  // namespace ndg
