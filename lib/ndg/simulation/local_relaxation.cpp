// SPDX-License-Identifier: Apache-2.0
#include "ndg/simulation/local_relaxation.h"

#include "ndg/core/log.h"

#include <algorithm>
#include <numeric>

namespace ndg {

namespace {

/// Patches grow from the vertices that hold this share of the squared force,
constexpr double force_share = 0.9;
/// if they are no more than this share of all, and the patches together no more than that.
constexpr double max_seed_share = 0.03, max_patch_share = 0.12;
/// The first round's patches have so many rings, each later round's one more: what balances a patch disturbs its rim.
constexpr int first_rings = 3, max_rounds = 4;
/// A round that leaves more than this share of the force is the last.
constexpr double least_progress = 0.5;
/// A patch is at rest at this share of the whole body's force.
constexpr double patch_tolerance = 0.03;
constexpr int patch_iterations = 20;

std::size_t index(int i)
{
    return static_cast<std::size_t>(i);
}

}  // namespace

LocalRelaxation::LocalRelaxation(const Objective& objective)
    : objective_(objective), neighbours_(objective.vertices().size())
{
    const std::vector<int>& vertices = objective.vertices();
    std::vector<int> unknown_of(index(objective.body().num_vertices()), -1);
    for (std::size_t i = 0; i < vertices.size(); ++i) unknown_of[index(vertices[i])] = static_cast<int>(i);
    for (const auto& term : objective.body().terms()) {
        term->stencils().for_adjacent([&](int a, int b) {
            const int row = unknown_of[a], other = unknown_of[b];
            if (row >= 0 && other >= 0) neighbours_[row].push_back(other);
        });
    }
    for (std::vector<int>& list : neighbours_) {
        std::sort(list.begin(), list.end());
        list.erase(std::unique(list.begin(), list.end()), list.end());
    }
}

std::vector<std::vector<int>> LocalRelaxation::find_patches(const Eigen::VectorXd& gradient, int rings) const
{
    const std::size_t num_unknown = neighbours_.size();
    std::vector<double> force(num_unknown);
    for (std::size_t v = 0; v < num_unknown; ++v) {
        force[v] = gradient.segment<3>(3 * static_cast<Eigen::Index>(v)).squaredNorm();
    }
    std::vector<int> order(num_unknown);
    std::iota(order.begin(), order.end(), 0);
    const auto max_seeds =
        std::min(num_unknown, static_cast<std::size_t>(max_seed_share * static_cast<double>(num_unknown)) + 1);
    std::partial_sort(
        order.begin(), order.begin() + static_cast<std::ptrdiff_t>(max_seeds), order.end(),
        [&](int a, int b) { return force[index(a)] != force[index(b)] ? force[index(a)] > force[index(b)] : a < b; });
    const double wanted = force_share * std::accumulate(force.begin(), force.end(), 0.0);
    std::vector<char> chosen(num_unknown, 0);
    std::vector<int> rim;
    double sum = 0;
    for (std::size_t i = 0; i < max_seeds && sum < wanted; ++i) {
        sum += force[index(order[i])];
        chosen[index(order[i])] = 1;
        rim.push_back(order[i]);
    }
    if (sum < wanted) return {};
    std::size_t count = rim.size();
    for (int ring = 0; ring < rings; ++ring) {
        std::vector<int> next;
        for (const int v : rim) {
            for (const int other : neighbours_[index(v)]) {
                if (chosen[index(other)]) continue;
                chosen[index(other)] = 1;
                next.push_back(other);
            }
        }
        count += next.size();
        rim = std::move(next);
    }
    if (static_cast<double>(count) > max_patch_share * static_cast<double>(num_unknown)) return {};

    std::vector<std::vector<int>> patches;
    for (std::size_t seed = 0; seed < num_unknown; ++seed) {
        if (!chosen[seed]) continue;
        std::vector<int> patch{static_cast<int>(seed)};
        chosen[seed] = 0;
        for (std::size_t i = 0; i < patch.size(); ++i) {
            for (const int other : neighbours_[index(patch[i])]) {
                if (!chosen[index(other)]) continue;
                chosen[index(other)] = 0;
                patch.push_back(other);
            }
        }
        std::sort(patch.begin(), patch.end());
        patches.push_back(std::move(patch));
    }
    return patches;
}

bool LocalRelaxation::relax(Points& positions, const Eigen::VectorXd& gradient, const StepFilter& filter)
{
    NewtonOptions options;
    options.relative_tolerance = 1e-9;
    options.max_iterations = patch_iterations;
    Eigen::VectorXd remaining = gradient, absolute;
    bool moved = false;
    for (int round = 0; round < max_rounds; ++round) {
        const double force = remaining.norm();
        options.absolute_tolerance_newton = patch_tolerance * force;
        int iterations = 0;
        const std::vector<std::vector<int>> patches = find_patches(remaining, first_rings + round);
        for (std::vector<int> patch : patches) {
            for (int& v : patch) v = objective_.vertices()[index(v)];
            const Objective part(objective_.body(), std::move(patch));
            iterations += NewtonSolver(part).minimise(positions, options, {}, filter).iterations;
        }
        if (iterations == 0) break;
        moved = true;
        objective_.gradient(positions, remaining, absolute);
        log_debug("{} patches, {} iterations: force {:.3e} N -> {:.3e} N", patches.size(), iterations, force,
                  remaining.norm());
        if (remaining.norm() > least_progress * force) break;
    }
    return moved;
}

}  // namespace ndg
