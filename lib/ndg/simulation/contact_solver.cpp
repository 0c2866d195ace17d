// SPDX-License-Identifier: Apache-2.0
#include "ndg/simulation/contact_solver.h"

#include "ndg/core/log.h"
#include "ndg/simulation/contact_filter.h"
#include "ndg/simulation/local_relaxation.h"
#include "ndg/simulation/untangle.h"

#include <algorithm>
#include <limits>

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
    const Eigen::VectorXd radii = Eigen::VectorXd::Constant(vertices.rows(), round_radius);
    for (int round = 0; round < max_rounds && iterations < max_iterations; ++round) {
        const Points start = vertices;
        std::vector<SurfacePair> found = parts_.close_pairs(vertices, 2 * round_radius + element_margin);
        remove_crossed(found, skin_, crossings);
        const std::vector<SurfacePair> near = near_pairs(found, vertices, distance_ + element_margin);
        if (near.empty() && vertices == given) break;
        term_->set_pairs(near);
        const Objective objective(elastic_);
        NewtonSolver newton(objective);
        LocalRelaxation relaxation(objective);
        const StepFilter filter = ContactFilter(start, radii, found, least_distance_share * distance_);
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
