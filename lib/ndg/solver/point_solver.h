// SPDX-License-Identifier: Apache-2.0
// One sparse symmetric positive definite matrix, solved again and again for the coordinates of points: frame by frame.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <array>
#include <memory>
#include <vector>

namespace ndg {

/// Three right-hand sides at once in single precision, on several cores. The factor is CHOLMOD's supernodal one, made
/// in double and rounded; supernodes are kept as L's diagonal block inverted over what is below it times that inverse,
/// so that both substitutions are plain products with one dense panel that is read once from its beginning to its end.
/// Subtrees of the elimination tree (nested dissection makes them large and alike) go to the cores; what is above them
/// is done by one. Results do not depend on the number of threads. One object per thread.
class PointSolver {
public:
    PointSolver();
    ~PointSolver();
    PointSolver(PointSolver&&) noexcept;
    PointSolver& operator=(PointSolver&&) noexcept;

    /// Orders and analyses the pattern of a symmetric matrix of which only the lower triangle is read. Must be
    /// compressed. Throws SolverError.
    void analyze(const Eigen::SparseMatrix<double>& matrix);
    /// A matrix with the analysed pattern. Throws SolverError when it is not positive definite or not finite.
    void factorize(const Eigen::SparseMatrix<double>& matrix);

    /// `points`: 4 x n, a column the three right-hand sides of an unknown; replaced by the solution. The fourth row is
    /// neither read nor written. At most about single precision times the root of the condition number off.
    void solve(Eigen::Ref<Eigen::Matrix4Xf> points);

    int num_unknowns() const { return static_cast<int>(unknown_at_.size()); }
    /// What one substitution reads: the panels and their row numbers, bytes.
    std::size_t substitution_bytes() const
    {
        return sizeof(float) * panels_.size() + sizeof(int) * (rows_.size() + unknown_at_.size());
    }

private:
    /// Columns of equal pattern, `num_columns` from `first_column` on. The rows of their panel are these columns, then
    /// those that stand in rows_ from `row_begin` on.
    struct Supernode {
        int first_column = 0, num_columns = 0, num_rows = 0;
        std::size_t row_begin = 0, panel_begin = 0;
        int source = 0;  ///< number in CHOLMOD's factor
    };
    /// What one core does of a substitution.
    struct Part {
        int begin = 0, end = 0;                    ///< of supernodes_
        std::array<std::vector<float>, 3> of_top;  ///< what it takes from the columns above all parts
        std::vector<float> lanes;                  ///< scratch of one supernode
    };
    struct Cholmod;

    void arrange(const std::vector<int>& parents, const std::vector<double>& costs);
    void forward(const Supernode& node, Part& part, bool is_top);
    void backward(const Supernode& node, Part& part);

    std::unique_ptr<Cholmod> cholmod_;
    std::vector<Supernode> supernodes_;  ///< part after part, then those above all parts
    std::vector<Part> parts_;            ///< the last one is what is above
    int first_top_column_ = 0;
    std::vector<int> rows_;        ///< positions of the panels' rows below their own columns
    std::vector<int> unknown_at_;  ///< unknown at each position of the factor
    std::vector<float> panels_;
    std::array<std::vector<float>, 3> x_;  ///< by position
};

}  // namespace ndg
