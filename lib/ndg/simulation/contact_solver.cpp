// SPDX-License-Identifier: Apache-2.0
#include "ndg/simulation/contact_solver.h"

#include "ndg/core/log.h"
#include "ndg/simulation/local_relaxation.h"
#include "ndg/simulation/untangle.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <set>

namespace ndg {

namespace {

/// How far a vertex may move in one round, m, and from which distance of two parts of the skin on they are looked
/// after.
constexpr double round_radius = 6e-3;
/// Pairs this much beyond the contact distance are elements already, m.
constexpr double element_margin = 2e-3;
constexpr int max_rounds = 100;
/// Iterations that contact may take, by those of a solve without.
constexpr int iteration_factor = 2;
/// A round in which nothing moves as much, m, is the last.
constexpr double least_movement = 1e-5;
/// So many rounds that lower the energy by less than this share of it are the last too.
constexpr double least_progress = 2e-5;
constexpr int max_stalled_rounds = 3;
/// Share of the contact distance that parts keep, so that the barrier's stiffness stays bounded.
constexpr double least_distance_share = 0.03;
/// Where vertices at the end of their way shorten the step by more than this, a new round begins.
constexpr double least_filtered_step = 0.2;
/// Pairs that would pass through each other are held back by themselves in so many passes, all vertices in the last.
constexpr int filter_passes = 4;

/// Straight ways that keep every vertex near its place at the start of the round, and all pairs apart.
class RoundFilter {
public:
    RoundFilter(const Points& start, const std::vector<SurfacePair>& pairs, double least_distance)
        : start_(start), pairs_(pairs), least_distance_(least_distance), begin_(start.rows() + 1, 0)
    {
        for (const SurfacePair& pair : pairs) {
            for (const int v : pair.vertices) ++begin_[v + 1];
        }
        std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
        pairs_at_.resize(4 * pairs.size());
        std::vector<int> end(begin_.begin(), begin_.end() - 1);
        for (int p = 0; p < int(pairs.size()); ++p) {
            for (const int v : pairs[p].vertices) pairs_at_[end[v]++] = p;
        }
    }

    bool operator()(const Points& from, Points& to, bool by_vertex) const
    {
        std::vector<int> moving, concerned;
        double wanted = 0, left = 0, least_in_ball = 1;
        for (int v = 0; v < from.rows(); ++v) {
            const Eigen::RowVector3d move = to.row(v) - from.row(v);
            const double length = move.norm();
            if (length == 0) continue;
            const double share = share_in_ball(from.row(v) - start_.row(v), move);
            least_in_ball = std::min(least_in_ball, share);
            if (by_vertex) to.row(v) = from.row(v) + share * move;
            wanted += std::min(length, round_radius);
            left += share * length;
            moving.push_back(v);
            concerned.insert(concerned.end(), pairs_at_.begin() + begin_[v], pairs_at_.begin() + begin_[v + 1]);
        }
        if (left < least_filtered_step * wanted) return false;
        const auto draw_back = [&](double share) {
            for (const int v : moving) to.row(v) = from.row(v) + share * (to.row(v) - from.row(v));
        };
        if (!by_vertex) draw_back(least_in_ball);
        std::sort(concerned.begin(), concerned.end());
        concerned.erase(std::unique(concerned.begin(), concerned.end()), concerned.end());
        std::vector<std::pair<int, double>> shares;
        for (int pass = by_vertex ? 0 : filter_passes; pass <= filter_passes; ++pass) {
            double least = 1;
            shares.clear();
            for (const int p : concerned) {
                const auto& vertices = pairs_[p].vertices;
                const double share = collision_free_share(pairs_[p].kind, pair_corners(from, vertices),
                                                          pair_corners(to, vertices), least_distance_);
                if (share == 1) continue;
                least = std::min(least, share);
                for (const int v : vertices) shares.emplace_back(v, share);
            }
            if (shares.empty()) return true;
            if (pass == filter_passes) {
                draw_back(least);
            } else {
                std::sort(shares.begin(), shares.end());  // a vertex's smallest first
                int last = -1;
                for (const auto& [v, share] : shares) {
                    if (v != last) to.row(v) = from.row(v) + share * (to.row(v) - from.row(v));
                    last = v;
                }
            }
        }
        return true;
    }

private:
    /// Largest share up to one with |offset + share move| <= radius.
    static double share_in_ball(const Eigen::RowVector3d& offset, const Eigen::RowVector3d& move)
    {
        const double along = offset.dot(move), length = move.squaredNorm();
        const double room = std::max(0.0, round_radius * round_radius - offset.squaredNorm());
        if (length + 2 * along <= room) return 1;
        return (std::sqrt(along * along + length * room) - along) / length;
    }

    const Points& start_;
    const std::vector<SurfacePair>& pairs_;
    double least_distance_;
    std::vector<int> begin_, pairs_at_;  ///< of vertex v: pairs_at_[begin_[v]] to pairs_at_[begin_[v + 1]]
};

}  // namespace

ContactSolver::ContactSolver(const Template& body_template, ElasticBody& elastic, const ContactOptions& options)
    : template_(body_template),
      elastic_(elastic),
      distance_(options.contact_distance),
      skin_(body_template.wrap_triangles.array() + 2 * body_template.num_wrap_vertices()),
      parts_(skin_, body_template.num_volume_vertices())
{
    auto term = std::make_unique<ContactTerm>(skin_, options, body_template.num_volume_vertices());
    term_ = term.get();
    elastic.add(std::move(term));
}

std::vector<SurfacePair> ContactSolver::pairs(const Points& vertices, double reach,
                                              const std::vector<std::pair<int, int>>& crossings) const
{
    std::vector<SurfacePair> pairs = parts_.close_pairs(vertices, reach);
    if (crossings.empty()) return pairs;
    std::set<std::pair<int, int>> left;  // vertices of triangles that cross each other
    for (const auto& [s, t] : crossings) {
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b) left.insert(std::minmax(skin_(s, a), skin_(t, b)));
    }
    pairs.erase(std::remove_if(pairs.begin(), pairs.end(),
                               [&](const SurfacePair& pair) {
                                   const int first = pair.kind == PairKind::point_triangle ? 1 : 2;
                                   for (int a = 0; a < first; ++a)
                                       for (int b = first; b < 4; ++b)
                                           if (!left.count(std::minmax(pair.vertices[a], pair.vertices[b])))
                                               return false;
                                   return true;
                               }),
                pairs.end());
    return pairs;
}

std::vector<SurfacePair> ContactSolver::near_pairs(const Points& vertices, const std::vector<SurfacePair>& pairs) const
{
    const double reach = distance_ + element_margin;
    std::vector<SurfacePair> near;
    std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(near), [&](const SurfacePair& pair) {
        return PairDistance(pair.kind, pair_corners(vertices, pair.vertices)).squared() < reach * reach;
    });
    return near;
}

void ContactSolver::solve(Points& vertices, const NewtonOptions& options, NewtonResult& result)
{
    const Points given = vertices;
    const std::vector<std::pair<int, int>> crossings = untangle(vertices, template_, distance_);
    if (!crossings.empty()) log_debug("{} pairs of skin triangles cannot be untangled", crossings.size());
    const int max_iterations = result.iterations + iteration_factor * options.max_iterations;
    int iterations = result.iterations, factorizations = result.factorizations;
    NewtonOptions rest = options;
    double energy = std::numeric_limits<double>::infinity();
    int stalled = 0;
    for (int round = 0; round < max_rounds && iterations < max_iterations; ++round) {
        const Points start = vertices;
        const std::vector<SurfacePair> found = pairs(vertices, 2 * round_radius + element_margin, crossings);
        const std::vector<SurfacePair> near = near_pairs(vertices, found);
        if (near.empty() && vertices == given) break;
        term_->set_pairs(near);
        const Objective objective(elastic_);
        NewtonSolver newton(objective);
        LocalRelaxation relaxation(objective);
        const StepFilter filter = RoundFilter(start, found, least_distance_share * distance_);
        rest.max_iterations = max_iterations - iterations;
        result = newton.minimise(
            vertices, rest,
            [&](Points& positions, const Eigen::VectorXd& gradient) {
                return relaxation.relax(positions, gradient, filter);
            },
            filter);
        iterations += result.iterations;
        factorizations += result.factorizations;
        log_debug("contact round {}: {} pairs near, {} iterations, {:.6f} J, relative residual {:.2e}, {}", round,
                  term_->stencils().size(), result.iterations, result.energy_joule, result.residual_relative,
                  describe(result.stop));
        // Equilibrium counts where no pair can have come near since the elements were chosen.
        const double moved = (vertices - start).rowwise().norm().maxCoeff();
        if (result.converged() ? 2 * moved <= element_margin : moved <= least_movement) break;
        stalled = result.energy_joule > (1 - least_progress) * energy ? stalled + 1 : 0;
        if (stalled == max_stalled_rounds) break;
        energy = result.energy_joule;
    }
    term_->set_pairs({});
    result.iterations = iterations;
    result.factorizations = factorizations;
}

}  // namespace ndg
