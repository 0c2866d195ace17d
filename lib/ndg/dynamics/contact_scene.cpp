// SPDX-License-Identifier: Apache-2.0
#include "ndg/dynamics/contact_scene.h"

#include "ndg/core/error.h"
#include "ndg/core/log.h"
#include "ndg/core/stopwatch.h"
#include "ndg/geometry/triangle_crossings.h"
#include "ndg/simulation/contact_filter.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace ndg {

namespace {

/// How far a vertex may move in one round, by the contact distance; farther where the guess was farther.
constexpr double round_radius_share = 2;
/// Pairs this much beyond the contact distance are elements already, by that distance.
constexpr double element_margin_share = 1;
/// Share of the contact distance that parts keep, so that the barrier's stiffness stays bounded.
constexpr double least_distance_share = 0.03;
/// A round in which nothing moves as much, m, is the last.
constexpr double least_movement = 1e-8;
/// Passes in which what hangs together is held back, all of it in the last.
constexpr int jump_passes = 6;
/// Springs that draw given vertices to their places, N/m: soft ones first, stiffer ones where a solve has found its
/// minimum or has not brought them half as far as it drew. None draws farther than so many contact distances at a time,
/// nor with more than so many times the force of the contact pressure's scale on one vertex: what they push is not to
/// be squeezed so flat that the linear systems, in single precision, no longer know how it could give way.
constexpr double first_anchor = 1e3, last_anchor = 1e7, anchor_factor = 10, anchor_progress = 0.5;
constexpr double anchor_reach = 4, anchor_force = 100;
constexpr int max_anchor_solves = 60;
/// Those solves only lead on to the next one.
constexpr double anchor_tolerance = 1e-2;
constexpr int anchor_iterations = 30;

bool nearer(const SurfacePair& pair, const Points& vertices, double reach)
{
    return PairDistance(pair.kind, pair_corners(vertices, pair.vertices)).squared() < reach * reach;
}

int root_of(std::vector<int>& parents, int v)
{
    while (parents[v] != v) v = parents[v] = parents[parents[v]];
    return v;
}

}  // namespace

ContactScene::ContactScene(ElasticBody& elastic, std::vector<ContactSurface> surfaces,
                           const ContactSceneOptions& options)
    : elastic_(elastic),
      surfaces_(std::move(surfaces)),
      options_((check_options(options), options)),
      surface_of_(static_cast<std::size_t>(elastic.num_vertices()), -1),
      crossings_(surfaces_.size())
{
    const int num_vertices = elastic.num_vertices();
    std::vector<Triangles> triangles;
    for (int s = 0; s < int(surfaces_.size()); ++s) {
        triangles.push_back(surfaces_[s].triangles);
        parts_.emplace_back(triangles.back(), num_vertices);
        for (const int vertex : triangles.back().reshaped()) surface_of_[vertex] = s;
    }
    const ContactOptions contact{true, options.contact_distance, options.contact_stiffness_pascal};
    const auto add = [&](auto term) {
        auto* pointer = term.get();
        elastic_.add(std::move(term));
        return pointer;
    };
    contact_ = add(std::make_unique<ContactTerm>(triangles, contact, num_vertices));
    friction_ = add(std::make_unique<FrictionTerm>(num_vertices));
    anchors_ = add(std::make_unique<ContactAnchors>(num_vertices));
}

void ContactScene::find_components()
{
    if (num_components_ > 0) return;
    const int num_vertices = elastic_.num_vertices();
    std::vector<int> parents(static_cast<std::size_t>(num_vertices));
    std::iota(parents.begin(), parents.end(), 0);
    const auto join = [&](int a, int b) { parents[root_of(parents, a)] = root_of(parents, b); };
    for (const auto& term : elastic_.terms()) {
        if (term.get() == contact_ || term.get() == friction_ || term.get() == anchors_) continue;
        const Stencils& stencils = term->stencils();
        for (int e = 0; e < stencils.size(); ++e) {
            for (int a = 1; a < stencils.num_corners(); ++a) join(stencils.corners(e)[0], stencils.corners(e)[a]);
        }
    }
    for (const ContactSurface& surface : surfaces_) {
        for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
            for (int a = 1; a < 3; ++a) join(surface.triangles(t, 0), surface.triangles(t, a));
        }
    }
    std::vector<int> number(parents.size(), -1);
    component_of_.resize(parents.size());
    for (int v = 0; v < num_vertices; ++v) {
        int& component = number[root_of(parents, v)];
        if (component < 0) component = num_components_++;
        component_of_[v] = component;
    }
}

std::vector<SurfacePair> ContactScene::close_pairs(const Points& positions, double reach, const Eigen::VectorXd& radii)
{
    const Stopwatch stopwatch(counts_.search_seconds);
    std::vector<SurfacePair> pairs;
    const auto add = [&](const std::vector<SurfacePair>& more) {
        for (const SurfacePair& pair : more) {
            if (!given(*std::max_element(pair.vertices.begin(), pair.vertices.end()))) pairs.push_back(pair);
        }
    };
    const auto all_given = [&](std::size_t s) { return given(parts_[s].points()[parts_[s].points().size() - 1]); };
    for (std::size_t s = 0; s < parts_.size(); ++s) {
        if (surfaces_[s].meets_itself) {
            std::vector<SurfacePair> own = parts_[s].close_pairs(positions, reach, radii);
            remove_crossed(own, surfaces_[s].triangles, crossings_[s]);
            add(own);
        }
        for (std::size_t t = s + 1; t < parts_.size(); ++t) {
            if (all_given(s) && all_given(t)) continue;
            add(parts_[s].close_pairs(parts_[t], positions, reach, radii));
        }
    }
    return pairs;
}

/// What hangs together goes by the same share, so that nothing is torn or turned inside out on the way.
void ContactScene::jump(Points& positions)
{
    const Points& start = step_start_;
    const Eigen::VectorXd moves = (wanted_ - start).rowwise().norm();
    const double least_distance = least_distance_share * options_.contact_distance;
    const std::vector<SurfacePair> pairs = close_pairs(start, options_.contact_distance, moves);
    Eigen::VectorXd shares = Eigen::VectorXd::Ones(num_components_);
    const auto place = [&](int v) -> Eigen::RowVector3d {
        return start.row(v) + shares[component_of_[v]] * (wanted_.row(v) - start.row(v));
    };
    for (int pass = 0; pass <= jump_passes; ++pass) {
        Eigen::VectorXd next = shares;
        double least = 1;
        for (const SurfacePair& pair : pairs) {
            PairCorners to;
            for (int a = 0; a < 4; ++a) to.row(a) = place(pair.vertices[a]);
            const double share =
                collision_free_share(pair.kind, pair_corners(start, pair.vertices), to, least_distance);
            if (share == 1) continue;
            least = std::min(least, share);
            for (const int v : pair.vertices) {
                const int c = component_of_[v];
                next[c] = std::min(next[c], share * shares[c]);
            }
        }
        if (least == 1) break;
        if (pass == jump_passes) next = least * shares;
        shares = next;
    }
    for (int v = 0; v < start.rows(); ++v) positions.row(v) = place(v);
}

void ContactScene::set_silent(bool silent)
{
    contact_->set_silent(silent);
    friction_->set_silent(silent);
}

double ContactScene::largest_pull() const
{
    return anchor_force * options_.contact_stiffness_pascal * contact_->mean_area();
}

std::vector<int> ContactScene::late_vertices(const Points& positions) const
{
    std::vector<int> late;
    for (int v = 0; v < elastic_.num_fixed_vertices(); ++v) {
        if (positions.row(v) != wanted_.row(v)) late.push_back(v);
    }
    return late;
}

NewtonResult ContactScene::draw_late(Points& positions, const std::vector<int>& late, double stiffness)
{
    const double longest = std::min(anchor_reach * options_.contact_distance, largest_pull() / stiffness);
    Points targets = wanted_;
    for (const int v : late) {
        const Eigen::RowVector3d way = wanted_.row(v) - positions.row(v);
        if (way.norm() > longest) targets.row(v) = positions.row(v) + longest / way.norm() * way;
    }
    anchors_->set(late, targets, stiffness);
    std::vector<int> unknown = late;
    for (int v = elastic_.num_fixed_vertices(); v < elastic_.num_vertices(); ++v) unknown.push_back(v);
    NewtonOptions options;
    options.relative_tolerance = anchor_tolerance;
    options.max_iterations = anchor_iterations;
    const Objective objective(elastic_, std::move(unknown), true);
    const NewtonResult result = NewtonSolver(objective).minimise(positions, options, {}, filter());
    anchors_->set({}, wanted_, 0);
    return result;
}

void ContactScene::stuck(const Points& positions, const std::vector<int>& late) const
{
    const auto way_left = [&](int v) { return (positions.row(v) - wanted_.row(v)).norm(); };
    const int vertex =
        *std::max_element(late.begin(), late.end(), [&](int a, int b) { return way_left(a) < way_left(b); });
    const int surface = surface_of_[vertex];
    double nearest = std::numeric_limits<double>::infinity();
    std::string other = "something";
    for (const SurfacePair& pair : found_) {
        const int a = surface_of_[pair.vertices[0]], b = surface_of_[pair.vertices[3]];
        if (a != surface && b != surface) continue;
        const double distance = PairDistance(pair.kind, pair_corners(positions, pair.vertices)).squared();
        if (distance >= nearest) continue;
        nearest = distance;
        other = surfaces_[a == surface ? b : a].name;
    }
    throw Error(fmt::format("{} cannot go on at {:.4f} s: {} is in its way and cannot give way, {:.2f} mm are left",
                            surfaces_[surface].name, end_time_, other, 1e3 * way_left(vertex)));
}

void ContactScene::bring_given(Points& positions)
{
    const double least_distance = least_distance_share * options_.contact_distance;
    double stiffness = first_anchor;
    const auto way_left = [&] {
        return (wanted_ - positions).topRows(elastic_.num_fixed_vertices()).rowwise().norm().maxCoeff();
    };
    for (std::vector<int> late = late_vertices(positions); !late.empty(); late = late_vertices(positions)) {
        find_round(positions);
        Points arrived = positions;
        for (const int v : late) arrived.row(v) = wanted_.row(v);
        const bool free_way = std::all_of(found_.begin(), found_.end(), [&](const SurfacePair& pair) {
            return collision_free_share(pair.kind, pair_corners(positions, pair.vertices),
                                        pair_corners(arrived, pair.vertices), least_distance) == 1;
        });
        if (free_way) {
            positions = arrived;
            return;
        }
        if (counts_.anchor_solves == max_anchor_solves) stuck(positions, late);
        select_elements(positions);
        const double before = way_left();
        const NewtonResult result = draw_late(positions, late, stiffness);
        counts_.anchor_iterations += result.iterations;
        ++counts_.anchor_solves;
        log_debug("{} given vertices are late by {:.3e} m, now {:.3e} m; springs of {:.0e} N/m, {} iterations, {}",
                  late.size(), before, way_left(), stiffness, result.iterations, describe(result.stop));
        const double drawn = std::min({before, anchor_reach * options_.contact_distance, largest_pull() / stiffness});
        if (result.converged() || (result.stop != NewtonStop::held && before - way_left() < anchor_progress * drawn)) {
            stiffness = std::min(last_anchor, anchor_factor * stiffness);
        }
    }
}

void ContactScene::begin_step(const DynamicState& state, double end_time, double time_step, Points& start)
{
    require(start.rows() == elastic_.num_vertices(), "{} vertices given, the scene has {}", start.rows(),
            elastic_.num_vertices());
    find_components();
    set_silent(false);
    counts_ = {};
    friction_solves_ = 0;
    step_start_ = state.positions;
    wanted_ = start;
    end_time_ = end_time;
    time_step_ = time_step;
    for (std::size_t s = 0; s < surfaces_.size(); ++s) {
        const Stopwatch stopwatch(counts_.search_seconds);
        if (surfaces_[s].meets_itself) crossings_[s] = crossing_triangles(step_start_, surfaces_[s].triangles);
    }
    jump(start);
    for (int v = 0; v < elastic_.num_fixed_vertices(); ++v) {
        if (surface_of_[v] < 0) start.row(v) = wanted_.row(v);
    }
    bring_given(start);
}

void ContactScene::find_round(const Points& positions)
{
    const double distance = options_.contact_distance;
    round_start_ = positions;
    radii_ = (wanted_ - positions).rowwise().norm().cwiseMax(round_radius_share * distance);
    found_ = close_pairs(positions, (1 + element_margin_share) * distance, radii_);
    for (int v = 0; v < positions.rows(); ++v) {
        if (surface_of_[v] < 0) radii_[v] = std::numeric_limits<double>::infinity();
    }
}

bool ContactScene::choose_elements(const Points& positions)
{
    ++counts_.rounds;
    select_elements(positions);
    return std::exchange(elements_changed_, false);
}

void ContactScene::select_elements(const Points& positions)
{
    const double distance = options_.contact_distance;
    find_round(positions);
    std::vector<SurfacePair> elements;
    is_element_.assign(found_.size(), 0);
    const double radius = round_radius_share * distance;
    for (std::size_t p = 0; p < found_.size(); ++p) {
        // What may go far in this round may come near; what pushes where the step starts has friction.
        double reach = (1 + element_margin_share) * distance;
        for (const int v : found_[p].vertices) reach += std::max(0.0, radii_[v] - radius) / 2;
        is_element_[p] = nearer(found_[p], positions, reach) || nearer(found_[p], step_start_, distance);
        if (is_element_[p]) elements.push_back(found_[p]);
    }
    counts_.candidates = static_cast<int>(found_.size());
    counts_.elements = static_cast<int>(elements.size());
    const auto same = [](const SurfacePair& a, const SurfacePair& b) {
        return a.kind == b.kind && a.vertices == b.vertices;
    };
    if (!std::equal(elements.begin(), elements.end(), elements_.begin(), elements_.end(), same)) {
        elements_changed_ = true;
        elements_ = std::move(elements);
        contact_->set_pairs(elements_);
        friction_->set_pairs(contact_->stencils());
    }
    set_friction(friction_solves_ == 0 ? step_start_ : positions);
}

void ContactScene::set_friction(const Points& lagged)
{
    const Stencils& pairs = contact_->stencils();
    std::vector<double> coefficients;
    for (int e = 0; e < pairs.size(); ++e) {
        const int* corners = pairs.corners(e);
        coefficients.push_back(
            friction_coefficient(surfaces_[surface_of_[corners[0]]], surfaces_[surface_of_[corners[3]]], options_));
    }
    friction_->set_step(contact_->forces(lagged), coefficients, step_start_, options_.slip_speed * time_step_);
}

StepFilter ContactScene::filter()
{
    ContactFilter filter(round_start_, radii_, found_, least_distance_share * options_.contact_distance);
    filter.keep_out(is_element_, options_.contact_distance);
    return filter;
}

bool ContactScene::goes_on(const Points& positions, const NewtonResult& round)
{
    const double moved = (positions - round_start_).rowwise().norm().maxCoeff();
    log_debug("contact round {}: {} of {} pairs are elements, {} iterations, relative residual {:.2e}, {}",
              counts_.rounds, counts_.elements, counts_.candidates, round.iterations, round.residual_relative,
              describe(round.stop));
    if (round.stop == NewtonStop::not_finite) return false;
    // Equilibrium counts where every pair that pushes is an element.
    bool settled = round.converged();
    for (std::size_t p = 0; p < found_.size() && settled; ++p) {
        settled = is_element_[p] || !nearer(found_[p], positions, options_.contact_distance);
    }
    if (settled) return ++friction_solves_ < options_.friction_solves;
    return moved > least_movement;
}

Points ContactScene::contact_forces(const Points& positions) const
{
    Points forces = Points::Zero(positions.rows(), 3);
    const std::vector<ContactForce> pairs = contact_->forces(positions);
    for (int e = 0; e < int(pairs.size()); ++e) {
        const int* corners = contact_->stencils().corners(e);
        for (int a = 0; a < 4; ++a) {
            forces.row(corners[a]) += pairs[e].newton * pairs[e].weights[a] * pairs[e].normal.transpose();
        }
    }
    return forces;
}

}  // namespace ndg
