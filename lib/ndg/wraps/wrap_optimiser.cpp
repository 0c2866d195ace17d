// SPDX-License-Identifier: Apache-2.0
#include "ndg/wraps/wrap_optimiser.h"

#include "ndg/core/error.h"
#include "ndg/core/log.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/wraps/minimise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>

namespace ndg {
namespace {

constexpr double shell_thickness = 0.0035;  ///< m of both layers together where the flow starts
constexpr double muscle_share = 0.45;       ///< of the way from skin to bone wrap, while the bone wrap flows alone
constexpr int iterations_per_factor = 5;
constexpr double max_move = 0.015;  ///< m, of a vertex in one iteration
constexpr double smallest_ridge = 1e-3, largest_ridge = 1e6;
constexpr double slack = 0.9;  ///< bounds rise to this share of what is reached

/// For each vertex the inward direction with the smallest largest angle to the inward normals of its triangles (the
/// centre of their bounding cone, after Badoiu and Clarkson 2003). A thin enough shell along them is valid if any is.
/// `height`: cosine of that angle.
Points visible_directions(const WrapSkin& skin, Eigen::VectorXd& height)
{
    constexpr int steps = 200;
    const Points normals = triangle_normals(skin.vertices, skin.triangles);
    std::vector<std::vector<Eigen::Index>> triangles_of(skin.vertices.rows());
    for (Eigen::Index t = 0; t < skin.triangles.rows(); ++t)
        for (int k = 0; k < 3; ++k) triangles_of[skin.triangles(t, k)].push_back(t);
    Points directions = -vertex_normals(skin.vertices, skin.triangles);
    height.resize(directions.rows());
#pragma omp parallel for schedule(static)
    for (Eigen::Index v = 0; v < directions.rows(); ++v) {
        Eigen::RowVector3d direction = directions.row(v);
        height[v] = -1.0;
        for (int step = 0; step < steps; ++step) {
            double lowest = std::numeric_limits<double>::max();
            Eigen::Index worst = -1;
            for (const Eigen::Index t : triangles_of[v]) {
                const double cosine = -direction.dot(normals.row(t));
                if (cosine < lowest) {
                    lowest = cosine;
                    worst = t;
                }
            }
            if (worst < 0) break;
            if (lowest > height[v]) {
                height[v] = lowest;
                directions.row(v) = direction;
            }
            direction = (direction - (1.0 / (step + 2.0)) * normals.row(worst)).normalized();
        }
    }
    return directions;
}

Eigen::Matrix<double, 6, 3> prism_of(const Points& outer, const Points& inner, const Triangles& triangles,
                                     Eigen::Index t)
{
    Eigen::Matrix<double, 6, 3> prism;
    for (int k = 0; k < 3; ++k) {
        prism.row(k) = outer.row(triangles(t, k));
        prism.row(3 + k) = inner.row(triangles(t, k));
    }
    return prism;
}

}  // namespace

WrapOptimiser::WrapOptimiser(const WrapSkin& skin, WrapEnergy& energy, const WrapTargets& targets, std::string name)
    : skin_(skin), energy_(energy), targets_(targets)
{
    Eigen::VectorXd height;
    const Points directions = visible_directions(skin, height);
    wraps_.bone = skin.vertices;
    for (Eigen::Index v = 0; v < height.size(); ++v)
        wraps_.bone.row(v) += shell_thickness / std::max(height[v], 0.3) * directions.row(v);
    wraps_.muscle = (1.0 - muscle_share) * skin.vertices + muscle_share * wraps_.bone;
    double lowest = std::numeric_limits<double>::max();
    Eigen::Index worst = 0;
    for (Eigen::Index t = 0; t < skin.triangles.rows(); ++t) {
        const double quality = std::min(prism_quality(prism_of(skin.vertices, wraps_.muscle, skin.triangles, t))[0],
                                        prism_quality(prism_of(wraps_.muscle, wraps_.bone, skin.triangles, t))[0]);
        if (quality >= lowest) continue;
        lowest = quality;
        worst = t;
    }
    const Eigen::RowVector3d place = skin.vertices.row(skin.triangles(worst, 0));
    require(lowest > 0.0,
            "{}: no shell under the skin is valid: near ({:.3f}, {:.3f}, {:.3f}) m its scaled Jacobian is {:.3g}", name,
            place[0], place[1], place[2], lowest);
    raise_bounds();
}

WrapOptimiser::WrapOptimiser(const WrapSkin& skin, WrapEnergy& energy, const WrapTargets& targets, WrapPair start)
    : skin_(skin), energy_(energy), targets_(targets), wraps_(std::move(start))
{
    raise_bounds();
}

void WrapOptimiser::raise_bounds()
{
#pragma omp parallel for schedule(static)
    for (Eigen::Index t = 0; t < skin_.triangles.rows(); ++t)
        for (int layer = 0; layer < 2; ++layer) {
            const Eigen::RowVector3d quality =
                prism_quality(layer == 0 ? prism_of(skin_.vertices, wraps_.muscle, skin_.triangles, t)
                                         : prism_of(wraps_.muscle, wraps_.bone, skin_.triangles, t));
            double& jacobian = energy_.jacobian_bounds(t, layer);
            double& thickness = energy_.thickness_bounds(t, layer);
            jacobian = std::max(jacobian, std::min(targets_.min_scaled_jacobian, slack * quality[0]));
            thickness = std::max(thickness, std::min(targets_.min_thickness, slack * quality[1]));
        }
}

int WrapOptimiser::flow(int max_iterations, double tolerance)
{
    const Eigen::Index count = skin_.vertices.rows();
    WrapPair trial, gradient;
    const auto objective = [&](const Points& both, Points& slope) {
        trial.bone = both.topRows(count);
        trial.muscle = both.bottomRows(count);
        const double value = energy_.evaluate(trial, &gradient);
        if (!std::isfinite(value)) return value;
        slope.resize(2 * count, 3);
        slope << gradient.bone, gradient.muscle;
        return value;
    };
    const auto precondition = [&](const Points& force) {
        Eigen::MatrixXd stacked(6 * count, 1);
        for (Eigen::Index v = 0; v < count; ++v)
            for (int c = 0; c < 3; ++c) {
                stacked(6 * v + c, 0) = force(v, c);
                stacked(6 * v + 3 + c, 0) = force(count + v, c);
            }
        const Eigen::MatrixXd solved = solver_.solve(stacked);
        Points result(2 * count, 3);
        for (Eigen::Index v = 0; v < count; ++v)
            for (int c = 0; c < 3; ++c) {
                result(v, c) = solved(6 * v + c, 0);
                result(count + v, c) = solved(6 * v + 3 + c, 0);
            }
        return result;
    };
    const auto limit = [&](const Points& at, Points& move) {
        WrapPair moves{move.topRows(count), move.bottomRows(count)};
        energy_.limit_move({at.topRows(count), at.bottomRows(count)}, moves);
        move << moves.bone, moves.muscle;
    };
    Points both(2 * count, 3);
    both << wraps_.bone, wraps_.muscle;
    MinimiseOptions options;
    options.max_move = max_move;
    options.tolerance = 0.0;
    int iterations = 0;
    double before = std::numeric_limits<double>::max();
    while (iterations < max_iterations) {
        // Rounding can make the matrix indefinite where prisms are all but flat; a larger ridge makes up for it.
        double ridge = smallest_ridge;
        for (bool factorised = false; !factorised; ridge *= 100.0) {
            if (ridge > largest_ridge) return iterations;  // nothing can move any more; the caller judges the state
            const Eigen::SparseMatrix<double>& hessian = energy_.hessian(wraps_, ridge);
            if (!analysed_) solver_.analyze(hessian);
            analysed_ = true;
            factorised = solver_.factorize(hessian);
        }
        options.max_iterations = std::min(iterations_per_factor, max_iterations - iterations);
        const MinimiseResult result = minimise(objective, precondition, limit, options, both);
        wraps_.bone = both.topRows(count);
        wraps_.muscle = both.bottomRows(count);
        iterations += result.iterations;
        log_debug("wraps: {} iterations, {} evaluations, energy {:.6g}", result.iterations, result.evaluations,
                  result.objective);
        if (result.iterations == 0 || before - result.objective <= tolerance * std::abs(result.objective)) break;
        before = result.objective;
    }
    raise_bounds();
    return iterations;
}

}  // namespace ndg
