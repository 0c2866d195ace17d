// SPDX-License-Identifier: Apache-2.0
// Where Newton's method goes from a state: the linear system, its factor, and when an earlier factor is good enough.
#pragma once

#include "ndg/elastic/objective.h"
#include "ndg/solver/single_cholesky.h"

namespace ndg {

/// Processor seconds of the parts of a solve.
struct NewtonTimes {
    double evaluation = 0;     ///< energies and gradients
    double assembly = 0;       ///< Hessians
    double factorization = 0;  ///< numeric
    double substitution = 0;   ///< and conjugate gradients
    double relaxation = 0;     ///< patches: all of the above in them, and their analysis

    NewtonTimes& operator+=(const NewtonTimes& other)
    {
        evaluation += other.evaluation;
        assembly += other.assembly;
        factorization += other.factorization;
        substitution += other.substitution;
        relaxation += other.relaxation;
        return *this;
    }
};

/// Directions for one objective, from one body and pose to the next; matrix and factor are kept. One object per thread.
///
/// Far from equilibrium every element's Hessian is projected (Teran et al. 2005). Nearer by only the worst elements
/// are, and near the minimum none, where that is definite. There the last factor also serves as preconditioner of a few
/// conjugate gradient iterations on the exact Hessian; a solution truncated after some of them, or where they meet
/// negative curvature, is a direction of descent too (Dembo and Steihaug 1983).
class NewtonDirection {
public:
    /// Keeps a reference to `objective`.
    explicit NewtonDirection(const Objective& objective);

    /// Forgets what was learned on the last body and pose; with `keep_factor` not the factor, which then serves as
    /// preconditioner at any residual until it does so badly.
    void start(bool keep_factor = false);
    /// False when no definite matrix is found. `residual_relative`: the forces out of balance by all element forces.
    bool find(const Points& positions, const Eigen::VectorXd& gradient, double residual_relative,
              Eigen::VectorXd& direction);
    /// Whether the last direction comes of a matrix stiffer than the exact Hessian, so that its step may be short.
    bool stiffened() const { return stiffened_; }
    /// The length of the step that the last direction was followed.
    void followed(double step);

    int factorizations() const { return factorizations_; }  ///< tried since start(), indefinite ones included
    int cg_iterations() const { return cg_iterations_; }    ///< since start()
    const NewtonTimes& seconds() const { return seconds_; }

private:
    void assemble(const Points& positions, HessianKind kind);
    bool factorize();
    bool factorize_definite(const Points& positions, bool far);
    bool precondition(const Points& positions, const Eigen::VectorXd& gradient, Eigen::VectorXd& direction);

    const Objective& objective_;
    Eigen::SparseMatrix<double> hessian_;
    SingleCholesky cholesky_;
    std::size_t level_ = 0;     ///< where factorize_definite starts
    double indefinite_at_ = 0;  ///< residual where a softer matrix than that of level_ was indefinite
    bool factored_ = false, stiffened_ = false, reuse_ = false, truncated_ = false, short_step_ = false;
    bool kept_ = false;  ///< the factor is of an earlier body or pose
    int factorizations_ = 0, cg_iterations_ = 0;
    NewtonTimes seconds_;
    Eigen::VectorXd residual_, preconditioned_, search_, product_;
};

}  // namespace ndg
