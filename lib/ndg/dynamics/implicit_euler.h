// SPDX-License-Identifier: Apache-2.0
// Implicit Euler's method for elastic bodies some of whose vertices are moved by others (Romero et al. 2020, 4.1), as a
// minimisation (Martin et al. 2011): of sum m |x - (x_0 + h v_0)|^2 / (2 h^2) + elastic energy - work of loads.
#pragma once

#include "ndg/dynamics/point_terms.h"
#include "ndg/dynamics/step_hook.h"
#include "ndg/elastic/elastic_body.h"

#include <memory>
#include <vector>

namespace ndg {

struct ImplicitEulerOptions {
    double time_step_seconds = 1.0 / 120;
    NewtonOptions newton;
    bool keep_factor = true;  ///< from one step to the next
    int max_rounds = 50;      ///< that a hook may ask for
};

/// One body through time. What it has no damping but that of the method, which is of first order. One object a thread.
class ImplicitEuler {
public:
    /// Adds its terms to `body`, to which it keeps a reference. `masses`: one a vertex, kg; `free`: vertices that move
    /// by themselves, ascending; empty: all but the body's fixed ones. Throws Error where one of them has no mass, for
    /// another number of masses, and for a body that has an integrator already.
    ImplicitEuler(ElasticBody& body, const Eigen::VectorXd& masses, const ImplicitEulerOptions& options,
                  std::vector<int> free = {});

    /// From now on: mass that hangs on vertices, kg, and forces, N_v x 3, N. Added mass has the velocity of its vertex.
    /// Throws Error for other numbers, negative masses and forces that are not finite.
    void set_loads(const Eigen::VectorXd& added_masses, const Points& forces);

    /// One step. `start`: N_v x 3, where the vertices that are not free are at its end, and where Newton's method
    /// begins with the others. `state` is moved on in any case; the result tells whether Newton's method converged.
    /// Throws SolverError where the energy at the start is not finite, Error for other numbers of vertices or values
    /// that are not finite.
    NewtonResult step(DynamicState& state, const Points& start, double end_time = 0, StepHook* hook = nullptr);
    /// The next step begins without what the last one left, as the first does.
    void forget() { fresh_ = true; }

    /// Joule, of the free vertices.
    double kinetic_energy(const DynamicState& state) const;
    /// Joule, of all but inertia and loads.
    double potential_energy(const Points& positions);
    /// What a step from `state` minimises, at `positions`, J.
    double incremental_potential(const DynamicState& state, const Points& positions);

    const std::vector<int>& free_vertices() const { return free_; }
    const ImplicitEulerOptions& options() const { return options_; }

private:
    void begin(const DynamicState& state);
    void make_objective();
    NewtonResult solve(Points& positions, const StepFilter& filter);

    ElasticBody& body_;
    ImplicitEulerOptions options_;
    std::vector<int> free_;
    Eigen::VectorXd own_masses_, masses_;  ///< kg; masses_ with what hangs on vertices
    Points forces_;
    InertiaTerm* inertia_;
    LoadTerm* loads_;
    std::unique_ptr<ElementPlaces> points_;  ///< the free vertices as elements of both
    std::unique_ptr<Objective> objective_;
    std::unique_ptr<NewtonSolver> newton_;
    bool fresh_ = true;
};

}  // namespace ndg
