// SPDX-License-Identifier: Apache-2.0
// Vertices from deformation gradients (NDG 4.2, equations 9 and 10).
#pragma once

#include "ndg/core/types.h"
#include "ndg/deform/rest_operators.h"
#include "ndg/solver/sparse_cholesky.h"

#include <Eigen/SparseCore>

#include <vector>

namespace ndg {

/// Minimises sum_p V_p |F_p^T - G_p X|^2 over the muscle wrap and skin vertices, the bone wrap (the first
/// `num_wrap_vertices` rows of X) given. V_p: rest volumes. The matrix is factored once a body; a frame costs a
/// right-hand side and a back-substitution. One object per thread (the solver's scratch space is its own). The factor
/// is simplicial: it is as fast here, and does not go through BLAS, whose sums depend on the processor (and with them
/// in which of several equilibria a fold of the simulation ends).
class PoissonReconstruction {
public:
    /// Copies what it needs of `rest`. Throws SolverError when the system is not positive definite.
    PoissonReconstruction(const RestOperators& rest, int num_wrap_vertices);

    /// Another body of the same template: new operators and factor, same symbolic analysis.
    void set_rest(const RestOperators& rest);

    /// `gradients`: N_p x 9, F_p row-major; `bone_wrap`: N_w x 3. Returns N_v x 3, its first N_w rows = `bone_wrap`.
    Points reconstruct(const Eigen::Ref<const Gradients>& gradients, const Eigen::Ref<const Points>& bone_wrap) const;
    Points reconstruct(const Eigen::Ref<const GradientsF>& gradients, const Eigen::Ref<const Points>& bone_wrap) const;
    /// F_p = prism_rotations[p].
    Points reconstruct(const std::vector<Eigen::Matrix3d>& prism_rotations,
                       const Eigen::Ref<const Points>& bone_wrap) const;

    int num_prisms() const { return static_cast<int>(prisms_.rows()); }
    double factor_nonzeros() const { return cholesky_.factor_nonzeros(); }

private:
    /// V_p G_p^T.
    using WeightedOperator = Eigen::Matrix<double, 6, 3, Eigen::RowMajor>;

    template <typename GradientAt>
    Points solve(const GradientAt& gradient_at, const Eigen::Ref<const Points>& bone_wrap) const;

    Prisms prisms_;
    int num_wrap_vertices_ = 0;
    int num_vertices_ = 0;
    std::vector<WeightedOperator> weighted_operators_;
    /// Free rows, Dirichlet columns of G^T W G.
    Eigen::SparseMatrix<double> coupling_;
    SparseCholesky cholesky_;
    bool analyzed_ = false;
};

}  // namespace ndg
