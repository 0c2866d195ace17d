// SPDX-License-Identifier: Apache-2.0
#include "ndg/wraps/minimise.h"

#include "ndg/core/error.h"

#include <cmath>
#include <deque>
#include <vector>

namespace ndg {
namespace {

constexpr std::size_t history_length = 12;
constexpr int max_halvings = 30;
constexpr double sufficient_decrease = 1e-4;
constexpr std::size_t patience = 10;  ///< iterations over which progress is judged

double dot(const Points& a, const Points& b)
{
    return a.cwiseProduct(b).sum();
}

struct Pair {
    Points step, change;
    double curvature;
};

/// Two-loop recursion.
Points direction(const Points& gradient, const std::deque<Pair>& history,
                 const std::function<Points(const Points&)>& precondition)
{
    Points q = gradient;
    std::vector<double> alpha(history.size());
    for (std::size_t i = history.size(); i-- > 0;) {
        alpha[i] = dot(history[i].step, q) / history[i].curvature;
        q -= alpha[i] * history[i].change;
    }
    Points r = precondition(q);
    for (std::size_t i = 0; i < history.size(); ++i) {
        const double beta = dot(history[i].change, r) / history[i].curvature;
        r += (alpha[i] - beta) * history[i].step;
    }
    return -r;
}

}  // namespace

MinimiseResult minimise(const std::function<double(const Points&, Points&)>& objective,
                        const std::function<Points(const Points&)>& precondition,
                        const std::function<void(const Points&, Points&)>& limit, const MinimiseOptions& options,
                        Points& points)
{
    MinimiseResult result;
    Points gradient, trial_gradient;
    double value = objective(points, gradient);
    result.evaluations = 1;
    require(std::isfinite(value), "minimisation starts from an invalid state");
    std::deque<Pair> history;
    std::deque<double> values = {value};
    while (result.iterations < options.max_iterations) {
        Points move = direction(gradient, history, precondition);
        double slope = dot(move, gradient);
        if (!(slope < 0.0)) {
            if (history.empty()) break;
            history.clear();
            continue;
        }
        const double largest = std::sqrt(move.rowwise().squaredNorm().maxCoeff());
        move *= std::min(1.0, options.max_move / largest);
        Points limited = move;
        limit(points, limited);
        // A limited move may lose its descent; the plain one is then shortened as a whole.
        if (dot(limited, gradient) < 0.0) move = std::move(limited);
        slope = dot(move, gradient);
        double step = 1.0;
        Points trial;
        double trial_value = 0.0;
        bool accepted = false;
        for (int halving = 0; halving < max_halvings; ++halving, step *= 0.5) {
            trial = points + step * move;
            trial_value = objective(trial, trial_gradient);
            ++result.evaluations;
            if (std::isfinite(trial_value) && trial_value <= value + sufficient_decrease * step * slope) {
                accepted = true;
                break;
            }
        }
        if (!accepted) {
            if (history.empty()) break;
            history.clear();
            continue;
        }
        Pair pair{trial - points, trial_gradient - gradient, 0.0};
        pair.curvature = dot(pair.step, pair.change);
        if (pair.curvature > 1e-12 * std::sqrt(pair.step.squaredNorm() * pair.change.squaredNorm())) {
            history.push_back(std::move(pair));
            if (history.size() > history_length) history.pop_front();
        }
        points = std::move(trial);
        std::swap(gradient, trial_gradient);
        value = trial_value;
        ++result.iterations;
        values.push_back(value);
        if (values.size() <= patience) continue;
        if (values.front() - value <= options.tolerance * std::abs(value)) break;
        values.pop_front();
    }
    result.objective = value;
    return result;
}

}  // namespace ndg
