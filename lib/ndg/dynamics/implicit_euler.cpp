// SPDX-License-Identifier: Apache-2.0
#include "ndg/dynamics/implicit_euler.h"

#include "ndg/core/error.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ndg {

namespace {

/// Conjugate gradient iterations in a solve after which its factor is not kept for the next.
constexpr int most_cg_iterations = 6;

template <class Term>
Term* add_term(ElasticBody& body)
{
    auto term = std::make_unique<Term>(body.num_vertices());
    Term* pointer = term.get();
    body.add(std::move(term));
    return pointer;
}

}  // namespace

ImplicitEuler::ImplicitEuler(ElasticBody& body, const Eigen::VectorXd& masses, const ImplicitEulerOptions& options,
                             std::vector<int> free)
    : body_(body),
      options_(options),
      free_(std::move(free)),
      own_masses_(masses),
      masses_(masses),
      forces_(Points::Zero(body.num_vertices(), 3)),
      inertia_(add_term<InertiaTerm>(body)),
      loads_(add_term<LoadTerm>(body))
{
    if (free_.empty()) {
        free_.resize(body.num_vertices() - body.num_fixed_vertices());
        std::iota(free_.begin(), free_.end(), body.num_fixed_vertices());
    }
    const auto inertias = std::count_if(body.terms().begin(), body.terms().end(), [](const auto& term) {
        return dynamic_cast<const InertiaTerm*>(term.get()) != nullptr;
    });
    require(inertias == 1, "a body cannot be moved by two integrators: its inertia would count twice");
    require(masses.size() == body.num_vertices(), "{} masses for {} vertices", masses.size(), body.num_vertices());
    for (const int v : free_) {
        require(std::isfinite(masses[v]) && masses[v] > 0, "vertex {} is free and has a mass of {} kg", v, masses[v]);
    }
    require(std::isfinite(options.time_step_seconds) && options.time_step_seconds > 0, "a time step of {} s",
            options.time_step_seconds);
    points_ = std::make_unique<ElementPlaces>(inertia_->stencils(), free_);
}

void ImplicitEuler::set_loads(const Eigen::VectorXd& added_masses, const Points& forces)
{
    require(added_masses.size() == own_masses_.size() && forces.rows() == own_masses_.size(),
            "loads of {} masses and {} forces for {} vertices", added_masses.size(), forces.rows(), own_masses_.size());
    require(forces.allFinite() && added_masses.allFinite() && (added_masses.array() >= 0).all(),
            "loads must be finite and their masses not negative");
    masses_ = own_masses_ + added_masses;
    forces_ = forces;
}

void ImplicitEuler::make_objective()
{
    newton_.reset();
    objective_ = std::make_unique<Objective>(body_, free_);
    newton_ = std::make_unique<NewtonSolver>(*objective_);
    fresh_ = true;
}

void ImplicitEuler::begin(const DynamicState& state)
{
    const Points inertial = state.positions + options_.time_step_seconds * state.velocities;
    inertia_->set_step(masses_, inertial, options_.time_step_seconds);
    loads_->set_forces(forces_, inertial);
}

double ImplicitEuler::incremental_potential(const DynamicState& state, const Points& positions)
{
    if (!objective_) make_objective();
    begin(state);
    return objective_->energy(positions);
}

NewtonResult ImplicitEuler::solve(Points& positions, const StepFilter& filter)
{
    if (options_.keep_factor && !fresh_) newton_->keep_factor();
    NewtonResult result = newton_->minimise(positions, options_.newton, {}, filter);
    // Where limbs turn, the factor ages: a new one costs as much as some iterations with the old one.
    fresh_ = result.cg_iterations > most_cg_iterations;
    return result;
}

NewtonResult ImplicitEuler::step(DynamicState& state, const Points& start, double end_time, StepHook* hook)
{
    const Eigen::Index count = body_.num_vertices();
    require(state.positions.rows() == count && state.velocities.rows() == count && start.rows() == count,
            "a state of {} positions and {} velocities, started at {}, of a body of {} vertices",
            state.positions.rows(), state.velocities.rows(), start.rows(), count);
    require(state.positions.allFinite() && state.velocities.allFinite() && start.allFinite(),
            "positions or velocities are not finite at {} s", end_time);
    Points positions = start;
    begin(state);
    if (hook != nullptr) hook->begin_step(state, end_time, options_.time_step_seconds, positions);
    NewtonResult result;
    for (int round = 0; round == 0 || (hook != nullptr && round < options_.max_rounds); ++round) {
        const bool changed = hook != nullptr && hook->choose_elements(positions);
        if (!objective_ || changed) make_objective();
        NewtonResult next = solve(positions, hook != nullptr ? hook->filter() : StepFilter());
        if (next.stop == NewtonStop::not_finite) {
            throw SolverError(fmt::format("the energy is not finite where the step to {:.4f} s begins", end_time));
        }
        next.iterations += result.iterations;
        next.factorizations += result.factorizations;
        next.cg_iterations += result.cg_iterations;
        next.seconds += result.seconds;
        result = std::move(next);
        if (hook == nullptr || !hook->goes_on(positions, result)) break;
    }
    state.velocities = (positions - state.positions) / options_.time_step_seconds;
    state.positions = std::move(positions);
    return result;
}

double ImplicitEuler::kinetic_energy(const DynamicState& state) const
{
    double energy = 0;
    for (const int v : free_) energy += 0.5 * masses_[v] * state.velocities.row(v).squaredNorm();
    return energy;
}

double ImplicitEuler::potential_energy(const Points& positions)
{
    if (!objective_) make_objective();
    EnergySum of_points;
    inertia_->add_energy(positions, *points_, of_points);
    loads_->add_energy(positions, *points_, of_points);
    return objective_->energy(positions) - of_points.total();
}

}  // namespace ndg
