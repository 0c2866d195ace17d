// SPDX-License-Identifier: Apache-2.0
// Sparse symmetric positive definite systems by CHOLMOD, behind a header free of its types.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <memory>

namespace ndg {

/// Factor once, solve many; the symbolic analysis is reused while the pattern stays. One object per thread.
class SparseCholesky {
public:
    enum class Method { automatic, simplicial, supernodal };

    explicit SparseCholesky(Method method = Method::automatic);
    ~SparseCholesky();
    SparseCholesky(SparseCholesky&&) noexcept;
    SparseCholesky& operator=(SparseCholesky&&) noexcept;

    /// Orders and analyses the pattern of a symmetric matrix; only the lower triangle of `matrix` is read (it may hold
    /// the full matrix). Must be compressed.
    void analyze(const Eigen::SparseMatrix<double>& matrix);
    /// Numeric factorisation of a matrix with the analysed pattern. Returns false when it is not positive definite;
    /// throws SolverError for non-finite values or a different pattern.
    bool factorize(const Eigen::SparseMatrix<double>& matrix);
    /// Solves for all columns of `right_hand_side` (n x k). Throws SolverError if not factorised.
    Eigen::MatrixXd solve(const Eigen::Ref<const Eigen::MatrixXd>& right_hand_side) const;
    /// Non-zeros of the factor.
    double factor_nonzeros() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace ndg
