// SPDX-License-Identifier: Apache-2.0
#include "ndg/simulation/newton_direction.h"

#include "ndg/core/stopwatch.h"

#include <algorithm>
#include <array>

namespace ndg {

namespace {

/// Tried in this order near equilibrium; the exact one below a residual where it mostly is definite.
constexpr std::array<HessianKind, 3> kinds{HessianKind::exact, HessianKind::nearly_exact, HessianKind::projected};
constexpr double exact_below_relative = 5e-3;
/// Above this residual only positive semi-definite elements are used.
constexpr double far_above_relative = 0.1;
constexpr int max_projected_attempts = 8;
/// A softer matrix is tried again once the residual has fallen to this share of where it was indefinite.
constexpr double retry_share = 0.6;

/// Below this residual an earlier factor may serve as preconditioner.
constexpr double precondition_below_relative = 0.05;
constexpr int max_cg_iterations = 8;
constexpr double cg_tolerance = 0.2;
/// With a factor kept from an earlier solve: states follow each other closely there, the energy is nearly quadratic,
/// and a Hessian costs more than an iteration.
constexpr double kept_cg_tolerance = 0.03;
constexpr int max_kept_cg_iterations = 12;
/// Negative curvature found sooner leaves a poor direction.
constexpr int least_cg_iterations = 3;
constexpr double least_step = 0.5;  ///< after a shorter one the factor is made anew

}  // namespace

NewtonDirection::NewtonDirection(const Objective& objective)
    : objective_(objective), hessian_(objective.hessian_pattern())
{
    cholesky_.analyze(hessian_);
}

void NewtonDirection::start(bool keep_factor)
{
    level_ = 0;
    indefinite_at_ = 0;
    stiffened_ = truncated_ = short_step_ = false;
    factored_ = reuse_ = kept_ = factored_ && keep_factor;
    factorizations_ = cg_iterations_ = 0;
    seconds_ = {};
}

void NewtonDirection::followed(double step)
{
    short_step_ = step < least_step;
    reuse_ = !short_step_ && !truncated_;
}

bool NewtonDirection::find(const Points& positions, const Eigen::VectorXd& gradient, double residual_relative,
                           Eigen::VectorXd& direction)
{
    truncated_ = false;
    std::size_t softest = residual_relative < exact_below_relative ? 0 : 1;
    if (factored_ && reuse_ && (kept_ || residual_relative < precondition_below_relative)) {
        if (precondition(positions, gradient, direction)) {
            stiffened_ = false;
            return true;
        }
        softest = 1;
    }
    const std::size_t level_before = level_;
    if (level_ > softest && residual_relative < retry_share * indefinite_at_) --level_;
    level_ = std::max(level_, softest);
    if (!factorize_definite(positions, residual_relative >= far_above_relative)) return false;
    if (level_ > level_before || level_ == kinds.size() - 1) indefinite_at_ = residual_relative;
    const Stopwatch stopwatch(seconds_.substitution);
    cholesky_.solve(gradient, direction);
    direction = -direction;
    return direction.dot(gradient) < 0;
}

void NewtonDirection::assemble(const Points& positions, HessianKind kind)
{
    const Stopwatch stopwatch(seconds_.assembly);
    objective_.hessian(positions, kind, hessian_);
}

bool NewtonDirection::factorize()
{
    const Stopwatch stopwatch(seconds_.factorization);
    ++factorizations_;
    kept_ = false;
    factored_ = cholesky_.factorize(hessian_);
    return factored_;
}

bool NewtonDirection::factorize_definite(const Points& positions, bool far)
{
    constexpr std::size_t last = kinds.size() - 1;
    if (far) level_ = last;
    bool factored = false;
    while (true) {
        assemble(positions, far && !short_step_ ? HessianKind::gauss_newton : kinds[level_]);
        factored = factorize();
        if (factored || level_ == last) break;
        ++level_;
    }
    stiffened_ = level_ > 0;
    // Clamped elements may leave a mode without stiffness; a little of it everywhere restores definiteness.
    double shift = 1e-6;
    for (int attempt = 1; attempt < max_projected_attempts && !factored; ++attempt) {
        hessian_.diagonal() += shift * hessian_.diagonal();
        factored = factorize();
        shift *= 10;
    }
    return factored;
}

bool NewtonDirection::precondition(const Points& positions, const Eigen::VectorXd& gradient, Eigen::VectorXd& direction)
{
    assemble(positions, HessianKind::exact);
    const Stopwatch stopwatch(seconds_.substitution);
    residual_ = -gradient;
    direction.setZero(gradient.size());
    cholesky_.solve(residual_, preconditioned_);
    search_ = preconditioned_;
    double rho = residual_.dot(preconditioned_);
    const double tolerance = kept_ ? kept_cg_tolerance : cg_tolerance;
    const double wanted = tolerance * tolerance * rho;
    for (int k = 0; k < (kept_ ? max_kept_cg_iterations : max_cg_iterations); ++k) {
        product_.noalias() = hessian_.selfadjointView<Eigen::Lower>() * search_;
        const double curvature = search_.dot(product_);
        if (!(curvature > 0)) {
            truncated_ = k >= least_cg_iterations;
            return truncated_;
        }
        ++cg_iterations_;
        const double alpha = rho / curvature;
        direction += alpha * search_;
        residual_ -= alpha * product_;
        cholesky_.solve(residual_, preconditioned_);
        const double next = residual_.dot(preconditioned_);
        if (next <= wanted) return true;
        search_ = preconditioned_ + (next / rho) * search_;
        rho = next;
    }
    truncated_ = true;
    return true;
}

}  // namespace ndg
