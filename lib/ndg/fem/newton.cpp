// SPDX-License-Identifier: Apache-2.0
#include "ndg/fem/newton.h"

#include "ndg/core/error.h"
#include "ndg/core/log.h"

#include <cmath>

namespace ndg {

namespace {

constexpr double armijo_share = 1e-4;
constexpr int max_halvings = 40;
constexpr double max_expansion = 64;
/// Below this residual the exact Hessian is tried before the projected one: near the minimum it is nearly always
/// positive definite as a whole, and its steps converge quadratically.
constexpr double exact_below_relative = 0.1;
constexpr double smallest_share = 1.0 / 64, share_growth = 4;
constexpr int max_projected_attempts = 8;

}  // namespace

void NewtonOptions::check() const
{
    require_input(relative_tolerance > 0 && relative_tolerance < 1,
                  "relative-tolerance is {}, it must lie between 0 and 1", relative_tolerance);
    require_input(std::isfinite(absolute_tolerance_newton) && absolute_tolerance_newton >= 0,
                  "absolute-tolerance is {}, it must not be negative", absolute_tolerance_newton);
    require_input(max_iterations > 0, "max-iterations is {}, it must be positive", max_iterations);
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
    }
    return "unknown";
}

NewtonSolver::NewtonSolver(const ElasticModel& model)
    : model_(model), hessian_(model.hessian_pattern()), cholesky_(SparseCholesky::Method::supernodal)
{
    cholesky_.analyze(hessian_);
}

bool NewtonSolver::factorize()
{
    ++factorizations_;
    return cholesky_.factorize(hessian_);
}

bool NewtonSolver::factorize_exact(const Points& vertices)
{
    model_.hessian(vertices, false, hessian_);
    if (projected_share_ == 0) {
        if (factorize()) return true;
        projected_share_ = smallest_share;
    }
    const auto num_values = hessian_.nonZeros();
    const Eigen::Map<Eigen::VectorXd> values(hessian_.valuePtr(), num_values);
    exact_values_ = values;
    model_.hessian(vertices, true, hessian_);
    projected_values_ = values;
    return false;
}

bool NewtonSolver::find_direction(const Points& vertices, bool try_exact)
{
    bool factored = false;
    stiffened_ = true;
    if (try_exact) {
        factored = factorize_exact(vertices);
        stiffened_ = !factored;
        Eigen::Map<Eigen::VectorXd> values(hessian_.valuePtr(), hessian_.nonZeros());
        while (!factored && projected_share_ < 1) {
            values = exact_values_ + projected_share_ * (projected_values_ - exact_values_);
            factored = factorize();
            if (!factored) projected_share_ *= share_growth;
        }
        if (!factored) values = projected_values_;
    } else {
        model_.hessian(vertices, true, hessian_);
    }
    // Clamped elements may leave a mode without stiffness; a little of it everywhere restores definiteness.
    double shift = 0;
    for (int attempt = 0; attempt < max_projected_attempts && !factored; ++attempt) {
        hessian_.diagonal() += shift * hessian_.diagonal();
        factored = factorize();
        shift = std::max(10 * shift, 1e-10);
    }
    projected_share_ = projected_share_ > smallest_share ? projected_share_ / share_growth : 0;
    if (factored) direction_ = -cholesky_.solve(gradient_);
    return factored;
}

double NewtonSolver::search(const Points& vertices, double energy)
{
    const Eigen::Index num_free = model_.num_dofs() / 3;
    const Eigen::Map<const Points> move(direction_.data(), num_free, 3);
    const double slope = gradient_.dot(direction_);
    const auto try_step = [&](double step, double bound) {
        trial_.bottomRows(num_free) = vertices.bottomRows(num_free) + step * move;
        trial_energy_ = model_.energy(trial_);
        return std::isfinite(trial_energy_) && trial_energy_ < bound &&
               trial_energy_ <= energy + armijo_share * step * slope;
    };
    trial_ = vertices;
    double step = 1;
    int halving = 0;
    for (; halving <= max_halvings && !try_step(step, energy); ++halving) step *= 0.5;
    if (halving > max_halvings) return 0;
    // A stiffened matrix gives short steps, and an energy costs a hundredth of a factorisation.
    if (halving == 0 && stiffened_) {
        double best = trial_energy_;
        while (step < max_expansion && try_step(2 * step, best)) {
            step *= 2;
            best = trial_energy_;
        }
        try_step(step, energy);
    }
    return step;
}

NewtonResult NewtonSolver::minimise(Points& vertices, const NewtonOptions& options)
{
    projected_share_ = 0;
    factorizations_ = 0;
    NewtonResult result;
    result.energy_joule = model_.energy(vertices);
    result.energies.push_back(result.energy_joule);
    if (!std::isfinite(result.energy_joule)) return result;

    while (true) {
        model_.gradient(vertices, gradient_, absolute_);
        result.residual_newton = gradient_.norm();
        const double total_force = absolute_.norm();
        result.residual_relative = total_force > 0 ? result.residual_newton / total_force : 0;
        if (result.residual_relative <= options.relative_tolerance ||
            result.residual_newton <= options.absolute_tolerance_newton) {
            result.stop = NewtonStop::converged;
            return result;
        }
        if (result.iterations >= options.max_iterations) {
            result.stop = NewtonStop::iteration_limit;
            return result;
        }
        result.stop = NewtonStop::no_descent;
        if (!find_direction(vertices, result.residual_relative < exact_below_relative)) return result;
        ++result.iterations;
        result.factorizations = factorizations_;

        const double step = search(vertices, result.energy_joule);
        const bool accepted = step > 0;
        const double energy = trial_energy_;
        log_debug("iteration {}: energy {:.9g} J, residual {:.2e}, step {}, share {:.2g}", result.iterations, energy,
                  result.residual_relative, step, projected_share_);
        if (!accepted) return result;
        vertices.swap(trial_);
        result.energy_joule = energy;
        result.energies.push_back(energy);
    }
}

}  // namespace ndg
