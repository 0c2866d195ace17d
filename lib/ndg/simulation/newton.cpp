// SPDX-License-Identifier: Apache-2.0
#include "ndg/simulation/newton.h"

#include "ndg/core/error.h"
#include "ndg/core/stopwatch.h"

#include <cmath>
#include <limits>

namespace ndg {

namespace {

constexpr double armijo_share = 1e-4;
constexpr int max_halvings = 40;
constexpr double max_expansion = 64;
/// Share of the energy that its sum over all elements may be wrong by.
constexpr double sum_rounding = 1e-14;

/// What rounding may make of the energy at these positions, J. Besides its sum, every element's energy errs by the work
/// of its forces along the rounding of its vertices' positions: in small strains, where forces are of first and
/// energies of second order, that is by far the larger part. `absolute`: see Objective::gradient.
double energy_rounding(double energy, const Objective& objective, const Points& positions,
                       const Eigen::VectorXd& absolute)
{
    double work = 0;
    for (std::size_t i = 0; i < objective.vertices().size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        work += positions.row(objective.vertices()[i]).cwiseAbs().dot(absolute.segment<3>(3 * row));
    }
    return sum_rounding * std::abs(energy) + std::numeric_limits<double>::epsilon() * work;
}

}  // namespace

void describe(OptionList& list, NewtonOptions& options)
{
    list.add("relative-tolerance", options.relative_tolerance, "converged at this share of forces out of balance",
             1e-14, 0.1);
    list.add("absolute-tolerance", options.absolute_tolerance_newton, "or at this norm of the forces out of balance, N",
             0, 1);
    list.add("max-iterations", options.max_iterations, "limit of Newton iterations a solve", 1, 10000);
}

std::string describe(NewtonStop stop)
{
    switch (stop) {
        case NewtonStop::converged:
            return "converged";
        case NewtonStop::iteration_limit:
            return "reached the limit of iterations";
        case NewtonStop::no_descent:
            return "found no step that lowers the energy";
        case NewtonStop::not_finite:
            return "started from a non-finite energy";
        case NewtonStop::held:
            return "was held by contact";
    }
    return "unknown";
}

void NewtonSolver::place(Points& positions, double step) const
{
    const std::vector<int>& vertices = objective_.vertices();
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        positions.row(vertices[i]) = start_.row(row) + step * move_.segment<3>(3 * row).transpose();
    }
}

bool NewtonSolver::restrict_move(Points& positions, const StepFilter& filter)
{
    const Points from = positions;
    const Eigen::VectorXd wanted = move_;
    const std::vector<int>& vertices = objective_.vertices();
    bool descends = false;
    for (const bool by_vertex : {true, false}) {
        move_ = wanted;
        place(positions, 1);
        if (!filter(from, positions, by_vertex)) break;
        for (std::size_t i = 0; i < vertices.size(); ++i) {
            const auto row = static_cast<Eigen::Index>(i);
            move_.segment<3>(3 * row) = (positions.row(vertices[i]) - start_.row(row)).transpose();
        }
        descends = gradient_.dot(move_) < 0;
        if (descends) break;
    }
    positions = from;
    return descends;
}

double NewtonSolver::search(Points& positions, double energy, const StepFilter& filter)
{
    const std::vector<int>& vertices = objective_.vertices();
    start_.resize(static_cast<Eigen::Index>(vertices.size()), 3);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        start_.row(static_cast<Eigen::Index>(i)) = positions.row(vertices[i]);
    }
    held_ = filter && !restrict_move(positions, filter);
    if (held_) return 0;
    const double slope = gradient_.dot(move_);
    const auto try_step = [&](double step, double bound) {
        place(positions, step);
        energy_ = objective_.energy(positions);
        return std::isfinite(energy_) && energy_ < bound && energy_ <= energy + armijo_share * step * slope;
    };
    // Where the step lowers the energy by less than its rounding, the slope at its end tells what the energy cannot
    // (Hager and Zhang 2005); for a quadratic function both say the same.
    const double rounding = energy_rounding(energy, objective_, positions, absolute_);
    if (-slope < rounding) {
        try_step(1, energy);
        objective_.gradient(positions, trial_gradient_, absolute_);
        if (std::isfinite(energy_) && energy_ <= energy + rounding &&
            trial_gradient_.dot(move_) <= (2 * armijo_share - 1) * slope && trial_gradient_.norm() < gradient_.norm()) {
            return 1;
        }
    }
    double step = 1;
    int halving = 0;
    for (; halving <= max_halvings && !try_step(step, energy); ++halving) step *= 0.5;
    if (halving > max_halvings) {
        place(positions, 0);
        return 0;
    }
    // A stiffened matrix gives short steps, and an energy costs a hundredth of a factorisation.
    if (halving == 0 && !filter && direction_.stiffened()) {
        double best = energy_;
        while (step < max_expansion && try_step(2 * step, best)) {
            step *= 2;
            best = energy_;
        }
        place(positions, step);
        energy_ = best;
    }
    return step;
}

NewtonResult NewtonSolver::minimise(Points& positions, const NewtonOptions& options, const Relaxation& relax,
                                    const StepFilter& filter)
{
    direction_.start(keep_factor_);
    keep_factor_ = false;
    NewtonResult result;
    double evaluation_seconds = 0, relaxation_seconds = 0;
    const auto evaluate_gradient = [&] {
        const Stopwatch stopwatch(evaluation_seconds);
        objective_.gradient(positions, gradient_, absolute_);
        result.residual_newton = gradient_.norm();
        const double total_force = absolute_.norm();
        result.residual_relative = total_force > 0 ? result.residual_newton / total_force : 0;
        return result.residual_relative <= options.relative_tolerance ||
               result.residual_newton <= options.absolute_tolerance_newton;
    };
    const auto relaxed = [&] {
        const Stopwatch stopwatch(relaxation_seconds);
        return relax && relax(positions, gradient_);
    };
    const auto finish = [&](NewtonStop stop) {
        result.stop = stop;
        result.factorizations = direction_.factorizations();
        result.cg_iterations = direction_.cg_iterations();
        result.seconds = direction_.seconds();
        result.seconds.evaluation = evaluation_seconds;
        result.seconds.relaxation = relaxation_seconds;
        return result;
    };

    result.energy_joule = result.start_energy_joule = objective_.energy(positions);
    if (!std::isfinite(result.energy_joule)) return finish(NewtonStop::not_finite);
    while (true) {
        if (evaluate_gradient()) return finish(NewtonStop::converged);
        if (result.iterations >= options.max_iterations) return finish(NewtonStop::iteration_limit);
        if (relaxed()) {
            result.energy_joule = objective_.energy(positions);
            if (evaluate_gradient()) return finish(NewtonStop::converged);
        }
        const int factorizations = direction_.factorizations(), cg_iterations = direction_.cg_iterations();
        if (!direction_.find(positions, gradient_, result.residual_relative, move_)) {
            return finish(NewtonStop::no_descent);
        }
        ++result.iterations;
        double step = 0;
        {
            const Stopwatch stopwatch(evaluation_seconds);
            step = search(positions, result.energy_joule, filter);
        }
        result.history.push_back({energy_, result.residual_relative, step, direction_.factorizations() - factorizations,
                                  direction_.cg_iterations() - cg_iterations});
        if (step == 0) return finish(held_ ? NewtonStop::held : NewtonStop::no_descent);
        direction_.followed(step);
        result.energy_joule = energy_;
    }
}

}  // namespace ndg
