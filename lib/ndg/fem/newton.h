// SPDX-License-Identifier: Apache-2.0
// Static equilibrium by Newton's method with a line search (Teran et al. 2005).
#pragma once

#include "ndg/fem/elastic_model.h"
#include "ndg/solver/sparse_cholesky.h"

#include <string>
#include <vector>

namespace ndg {

struct NewtonOptions {
    /// Converged when |g| <= relative_tolerance * |f|: g the out-of-balance force on the free vertices, f the vector of
    /// summed absolute element forces (ElasticModel::gradient).
    double relative_tolerance = 1e-5;
    /// Or when |g| is at most this, in newton: where there are hardly any forces at all, as at rest.
    double absolute_tolerance_newton = 1e-6;
    int max_iterations = 60;

    /// Throws InputError naming the value out of range.
    void check() const;
};

enum class NewtonStop { converged, iteration_limit, no_descent, not_finite };
/// The reason in words.
std::string describe(NewtonStop stop);

struct NewtonResult {
    NewtonStop stop = NewtonStop::not_finite;
    double energy_joule = 0;
    double residual_newton = 0;    ///< |g|, Euclidean norm over the free degrees of freedom
    double residual_relative = 0;  ///< |g| / |f|
    int iterations = 0;            ///< linear systems solved
    int factorizations = 0;        ///< tried for them, indefinite ones included
    std::vector<double> energies;  ///< at the start and after every iteration

    bool converged() const { return stop == NewtonStop::converged; }
};

/// Matrix, factor and vectors for one model, reused from one body and pose to the next. One object per thread.
class NewtonSolver {
public:
    /// Keeps a reference to `model`, whose rest shape may change between calls.
    explicit NewtonSolver(const ElasticModel& model);

    /// Moves the free vertices of `vertices` (N_v x 3) to equilibrium; the bone wrap stays. The energy falls with every
    /// iteration: no step is taken that does not lower it enough (Armijo) or that leads to a non-finite energy.
    NewtonResult minimise(Points& vertices, const NewtonOptions& options);

private:
    /// Direction for the current gradient; false when no positive definite matrix was found.
    bool find_direction(const Points& vertices, bool try_exact);
    bool factorize();
    /// Factors the exact Hessian at `vertices`; false where it is not definite, and then both the exact and the
    /// projected values are kept.
    bool factorize_exact(const Points& vertices);
    /// Length of the step that was accepted (0: none) from `vertices`, of the given energy; fills trial_.
    double search(const Points& vertices, double energy);

    const ElasticModel& model_;
    Eigen::SparseMatrix<double> hessian_;
    SparseCholesky cholesky_;
    Eigen::VectorXd gradient_, absolute_, direction_, exact_values_, projected_values_;
    double projected_share_ = 0;  ///< how far from the exact to the projected Hessian the last definite matrix lay
    bool stiffened_ = false;      ///< the factored matrix is not the exact Hessian
    double trial_energy_ = 0;
    int factorizations_ = 0;
    Points trial_;
};

}  // namespace ndg
