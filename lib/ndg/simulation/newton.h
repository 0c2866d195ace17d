// SPDX-License-Identifier: Apache-2.0
// Static equilibrium by Newton's method with a line search (Teran et al. 2005).
#pragma once

#include "ndg/core/options.h"
#include "ndg/simulation/newton_direction.h"

#include <functional>
#include <string>
#include <vector>

namespace ndg {

struct NewtonOptions {
    /// Converged when |g| <= relative_tolerance * |f|: g the out-of-balance force on the unknown vertices, f the vector
    /// of summed absolute element forces (Objective::gradient).
    double relative_tolerance = 1e-5;
    /// Or when |g| is at most this, in newton: where there are hardly any forces at all, as at rest.
    double absolute_tolerance_newton = 1e-6;
    int max_iterations = 60;
};
void describe(OptionList& list, NewtonOptions& options);

enum class NewtonStop { converged, iteration_limit, no_descent, not_finite, held };
/// The reason in words.
std::string describe(NewtonStop stop);

struct NewtonIteration {
    double energy_joule = 0;       ///< after it
    double residual_relative = 0;  ///< where its linear system was made
    double step = 0;               ///< share of the direction that was followed
    int factorizations = 0, cg_iterations = 0;
};

struct NewtonResult {
    NewtonStop stop = NewtonStop::not_finite;
    double energy_joule = 0;
    double residual_newton = 0;    ///< |g|, Euclidean norm over the unknowns
    double residual_relative = 0;  ///< |g| / |f|
    int iterations = 0;            ///< linear systems solved
    int factorizations = 0;        ///< tried for them, indefinite ones included
    int cg_iterations = 0;         ///< of the linear systems solved with an earlier factor
    NewtonTimes seconds;
    double start_energy_joule = 0;
    std::vector<NewtonIteration> history;

    bool converged() const { return stop == NewtonStop::converged; }
};

/// Called with the positions and the gradient there before a linear system is made: may lower the energy by moving
/// vertices, and then returns true.
using Relaxation = std::function<bool(Points& positions, const Eigen::VectorXd& gradient)>;

/// Draws `to` back towards `from`, as far as straight ways may be gone: vertex by vertex, or all by the same share;
/// false where none may.
using StepFilter = std::function<bool(const Points& from, Points& to, bool by_vertex)>;

/// Matrix, factor and vectors for one objective, reused from one body and pose to the next. One object per thread.
class NewtonSolver {
public:
    /// Keeps a reference to `objective`.
    explicit NewtonSolver(const Objective& objective) : objective_(objective), direction_(objective) {}

    /// Moves the unknown vertices of `positions` (N_v x 3) to equilibrium; the others stay. The energy falls with every
    /// iteration: no step is taken that does not lower it enough (Armijo) or that leads to a non-finite energy. Steps
    /// too small for the energy's rounding to tell must lower the slope and the gradient. With a `filter` no vertex
    /// goes farther than it allows; where it allows nothing that lowers the energy the solve stops, held.
    NewtonResult minimise(Points& positions, const NewtonOptions& options, const Relaxation& relax = {},
                          const StepFilter& filter = {});
    /// For solves that follow each other closely: the next one begins with the factor that the last one left.
    void keep_factor() { keep_factor_ = true; }

private:
    /// Moves `positions`, of the given energy, along move_ and fills energy_; returns the length of the step that was
    /// accepted (0: none, and nothing has moved).
    double search(Points& positions, double energy, const StepFilter& filter);
    /// Shortens move_ to what the filter allows from start_, vertex by vertex if that leads downwards; false for
    /// nothing.
    bool restrict_move(Points& positions, const StepFilter& filter);
    /// start_ + step * move_ in the rows of the unknown vertices.
    void place(Points& positions, double step) const;

    const Objective& objective_;
    NewtonDirection direction_;
    Eigen::VectorXd gradient_, absolute_, move_, trial_gradient_;
    Points start_;  ///< of the unknown vertices
    double energy_ = 0;
    bool keep_factor_ = false;
    bool held_ = false;  ///< whether the filter allowed the last search no step
};

}  // namespace ndg
