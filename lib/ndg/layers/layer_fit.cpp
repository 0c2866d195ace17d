// SPDX-License-Identifier: Apache-2.0
#include "ndg/layers/layer_fit.h"

#include "ndg/core/error.h"
#include "ndg/core/log.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/solver/sparse_cholesky.h"
#include "ndg/wraps/prism_barrier.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace ndg {
namespace {

constexpr int num_surfaces = 3;  ///< bone, muscle, skin: also the order of a column's unknowns
constexpr int column_size = 3 * num_surfaces;
constexpr double activity = 2.0;  ///< penalties begin at that many times what is wanted
constexpr double surplus = 1.02;  ///< of the wanted quality, so that it survives single precision
constexpr double weight_growth = 4.0, max_weight = 1e7;
constexpr int first_rings = 2;  ///< around bad prisms that are free in the first round
constexpr int max_newton_steps = 12;
constexpr double converged_share = 1e-4;  ///< of the energy, gained by a step
constexpr double ridge = 1e-6;
constexpr int rounds_to_restart = 4;       ///< after that many, columns whose prisms are still invalid start anew
constexpr double shell_thickness = 0.004;  ///< m of both layers together, there

using Surfaces = std::array<Points, num_surfaces>;

/// Prism of a triangle in the fat layer (1) or muscle layer (0).
PrismVertices prism_of(const Surfaces& surfaces, const Eigen::Ref<const Triangles>& triangles, Eigen::Index t,
                       int layer)
{
    PrismVertices prism;
    for (int k = 0; k < 3; ++k) {
        prism.row(k) = surfaces[layer + 1].row(triangles(t, k));
        prism.row(3 + k) = surfaces[layer].row(triangles(t, k));
    }
    return prism;
}

/// The columns (all three surfaces at a vertex) that are free, and the energy as a function of them.
class Patch {
public:
    Patch(const Eigen::Ref<const Triangles>& triangles, const Surfaces& targets, const Surfaces& start,
          const std::vector<std::vector<int>>& neighbours, const LayerFitOptions& options,
          const Eigen::ArrayX2d& weights, const std::vector<char>& is_free)
        : all_triangles_(triangles), targets_(targets), options_(options), weights_(weights), row_(is_free.size(), -1)
    {
        for (std::size_t v = 0; v < is_free.size(); ++v) {
            if (!is_free[v]) continue;
            row_[v] = static_cast<int>(free_.size());
            free_.push_back(static_cast<int>(v));
        }
        for (Eigen::Index t = 0; t < triangles.rows(); ++t)
            for (int k = 0; k < 3; ++k)
                if (is_free[triangles(t, k)]) {
                    triangles_.push_back(static_cast<int>(t));
                    break;
                }
        prepare_smoothness(neighbours, start);
    }

    const std::vector<int>& free() const { return free_; }

    double evaluate(const Surfaces& at, Eigen::VectorXd* gradient) const
    {
        double energy = 0.0;
        if (gradient != nullptr) gradient->setZero(column_size * static_cast<Eigen::Index>(free_.size()));
        for (const int t : triangles_)
            for (int layer = 0; layer < 2; ++layer) {
                PrismVertices slope = PrismVertices::Zero();
                const double weight = weights_(t, layer);
                const double penalty = prism_penalty(prism_of(at, all_triangles_, t, layer), active_jacobian(),
                                                     active_thickness(), gradient ? &slope : nullptr, nullptr);
                energy += weight * penalty;
                if (gradient == nullptr || penalty == 0.0) continue;
                for (int k = 0; k < 6; ++k) {
                    const int start = unknown(t, layer, k);
                    if (start >= 0) gradient->segment<3>(start) += weight * slope.row(k).transpose();
                }
            }
        const double unit = 1.0 / (options_.length_scale * options_.length_scale);
        for (int s = 0; s < num_surfaces; ++s) {
            const Points displacement = displacements(at, s);
            const Points bend = laplacian_ * displacement + fixed_bend_[s];
            energy += options_.smoothness * unit * bend.squaredNorm() + spring(s) * unit * displacement.squaredNorm();
            if (gradient == nullptr) continue;
            const Points force =
                options_.smoothness * unit * (laplacian_.transpose() * bend) + spring(s) * unit * displacement;
            for (std::size_t i = 0; i < free_.size(); ++i)
                gradient->segment<3>(column_size * static_cast<Eigen::Index>(i) + 3 * s) +=
                    2.0 * force.row(static_cast<Eigen::Index>(i)).transpose();
        }
        return energy;
    }

    /// Lower triangle, positive definite.
    Eigen::SparseMatrix<double> hessian(const Surfaces& at) const
    {
        std::vector<Eigen::Triplet<double>> entries;
        const double unit = 2.0 / (options_.length_scale * options_.length_scale);
        for (Eigen::Index c = 0; c < smoothness_.outerSize(); ++c)
            for (Eigen::SparseMatrix<double>::InnerIterator it(smoothness_, c); it; ++it) {
                if (it.row() < c) continue;
                for (int s = 0; s < num_surfaces; ++s) {
                    double value = options_.smoothness * unit * it.value();
                    if (it.row() == c) value += (spring(s) + ridge) * unit;
                    for (int k = 0; k < 3; ++k)
                        entries.emplace_back(column_size * static_cast<int>(it.row()) + 3 * s + k,
                                             column_size * static_cast<int>(c) + 3 * s + k, value);
                }
            }
        Eigen::Matrix<double, 18, 18> element;
        for (const int t : triangles_)
            for (int layer = 0; layer < 2; ++layer) {
                element.setZero();
                if (prism_penalty(prism_of(at, all_triangles_, t, layer), active_jacobian(), active_thickness(),
                                  nullptr, &element) == 0.0)
                    continue;
                for (int i = 0; i < 6; ++i)
                    for (int j = 0; j < 6; ++j) {
                        const int row = unknown(t, layer, i), column = unknown(t, layer, j);
                        if (row < 0 || column < 0 || row < column) continue;
                        for (int a = 0; a < 3; ++a)
                            for (int b = 0; b < 3; ++b)
                                if (row + a >= column + b)
                                    entries.emplace_back(row + a, column + b,
                                                         weights_(t, layer) * element(3 * i + a, 3 * j + b));
                    }
            }
        const auto size = column_size * static_cast<Eigen::Index>(free_.size());
        Eigen::SparseMatrix<double> matrix(size, size);
        matrix.setFromTriplets(entries.begin(), entries.end());
        matrix.makeCompressed();
        return matrix;
    }

    void move(Surfaces& at, const Eigen::VectorXd& step, double share) const
    {
        for (std::size_t i = 0; i < free_.size(); ++i)
            for (int s = 0; s < num_surfaces; ++s)
                at[s].row(free_[i]) +=
                    share * step.segment<3>(column_size * static_cast<Eigen::Index>(i) + 3 * s).transpose();
    }

private:
    double active_jacobian() const { return activity * options_.min_scaled_jacobian; }
    double active_thickness() const { return activity * options_.min_thickness; }
    double spring(int surface) const { return surface == 2 ? options_.skin_spring : options_.wrap_spring; }
    /// First unknown of corner k of a prism, -1 where its column is fixed.
    int unknown(int t, int layer, int k) const
    {
        const int row = row_[all_triangles_(t, k % 3)];
        return row < 0 ? -1 : column_size * row + 3 * (k < 3 ? layer + 1 : layer);
    }
    Points displacements(const Surfaces& at, int s) const
    {
        Points result(static_cast<Eigen::Index>(free_.size()), 3);
        for (std::size_t i = 0; i < free_.size(); ++i)
            result.row(static_cast<Eigen::Index>(i)) = at[s].row(free_[i]) - targets_[s].row(free_[i]);
        return result;
    }
    /// Umbrella Laplacian of the free columns, and what the displacements of the fixed ones add to it.
    void prepare_smoothness(const std::vector<std::vector<int>>& neighbours, const Surfaces& start)
    {
        std::vector<Eigen::Triplet<double>> entries;
        std::vector<int> centres;
        for (std::size_t v = 0; v < neighbours.size(); ++v) {
            const auto& ring = neighbours[v];
            if (row_[v] < 0 && std::none_of(ring.begin(), ring.end(), [&](int n) { return row_[n] >= 0; })) continue;
            const int row = static_cast<int>(centres.size());
            centres.push_back(static_cast<int>(v));
            if (row_[v] >= 0) entries.emplace_back(row, row_[v], -1.0);
            for (const int n : ring)
                if (row_[n] >= 0) entries.emplace_back(row, row_[n], 1.0 / static_cast<double>(ring.size()));
        }
        const auto rows = static_cast<Eigen::Index>(centres.size());
        laplacian_.resize(rows, static_cast<Eigen::Index>(free_.size()));
        laplacian_.setFromTriplets(entries.begin(), entries.end());
        smoothness_ = laplacian_.transpose() * laplacian_;
        for (std::size_t s = 0; s < num_surfaces; ++s) {
            fixed_bend_[s] = Points::Zero(rows, 3);
            for (Eigen::Index row = 0; row < rows; ++row) {
                const auto v = static_cast<std::size_t>(centres[row]);
                const auto add = [&](std::size_t vertex, double factor) {
                    if (row_[vertex] >= 0) return;
                    const auto index = static_cast<Eigen::Index>(vertex);
                    fixed_bend_[s].row(row) += factor * (start[s].row(index) - targets_[s].row(index));
                };
                add(v, -1.0);
                for (const int n : neighbours[v])
                    add(static_cast<std::size_t>(n), 1.0 / static_cast<double>(neighbours[v].size()));
            }
        }
    }

    const Eigen::Ref<const Triangles>& all_triangles_;
    const Surfaces& targets_;
    const LayerFitOptions& options_;
    const Eigen::ArrayX2d& weights_;
    std::vector<int> row_, free_, triangles_;
    Eigen::SparseMatrix<double> laplacian_, smoothness_;
    Surfaces fixed_bend_;
};

/// Newton's method with the Hessian's positive semi-definite part and backtracking.
void relax(const Patch& patch, Surfaces& at)
{
    constexpr int max_halvings = 20;
    constexpr double sufficient_decrease = 1e-4;
    Eigen::VectorXd gradient;
    double energy = patch.evaluate(at, &gradient);
    for (int step = 0; step < max_newton_steps; ++step) {
        // Where nothing is penalised the pattern lacks entries: it is analysed anew each time.
        SparseCholesky solver(SparseCholesky::Method::automatic);
        const Eigen::SparseMatrix<double> hessian = patch.hessian(at);
        solver.analyze(hessian);
        if (!solver.factorize(hessian)) return;
        const Eigen::VectorXd move = -solver.solve(gradient);
        const double slope = move.dot(gradient);
        double share = 1.0, trial_energy = 0.0;
        Surfaces trial;
        for (int halving = 0; halving < max_halvings; ++halving, share *= 0.5) {
            trial = at;
            patch.move(trial, move, share);
            trial_energy = patch.evaluate(trial, nullptr);
            if (trial_energy <= energy + sufficient_decrease * share * slope) break;
        }
        if (!(trial_energy < energy)) return;
        const bool converged = energy - trial_energy <= converged_share * energy;
        at = std::move(trial);
        energy = patch.evaluate(at, &gradient);
        if (converged) return;
    }
}

/// Puts the wraps of marked columns into a thin shell under the skin's target, which turns columns round that are
/// caught in a fold.
void restart_columns(const std::vector<char>& marked, const Points& skin, const Points& normals, Surfaces& at)
{
    for (std::size_t i = 0; i < marked.size(); ++i) {
        if (!marked[i]) continue;
        const auto v = static_cast<Eigen::Index>(i);
        at[2].row(v) = skin.row(v);
        at[1].row(v) = skin.row(v) - 0.5 * shell_thickness * normals.row(v);
        at[0].row(v) = skin.row(v) - shell_thickness * normals.row(v);
    }
}

/// Adds `rings` rings of neighbours to what is marked.
void grow(std::vector<char>& marked, const std::vector<std::vector<int>>& neighbours, int rings)
{
    for (int ring = 0; ring < rings; ++ring) {
        const std::vector<char> before = marked;
        for (std::size_t v = 0; v < before.size(); ++v)
            if (before[v])
                for (const int n : neighbours[v]) marked[n] = 1;
    }
}

}  // namespace

void describe(OptionList& list, LayerFitOptions& options)
{
    list.add("min-scaled-jacobian", options.min_scaled_jacobian, "prisms flatter than this are improved", 0.001, 0.5);
    list.add("min-thickness", options.min_thickness, "m, layers thinner than this are improved", 0.0001, 0.02);
    list.add("length-scale", options.length_scale, "m", 1e-4, 1).no_flag();
    list.add("skin-spring", options.skin_spring, "weight that holds skin vertices where they are", 0.01, 1e4);
    list.add("wrap-spring", options.wrap_spring, "weight that holds the wraps", 1e-3, 1e4).no_flag();
    list.add("smoothness", options.smoothness, "weight of the Laplacian of displacements", 0, 1e4);
    list.add("max-rounds", options.max_rounds, "of growing weights", 1, 1000).no_flag();
}

LayerSurfaces fit_layers(const Eigen::Ref<const Triangles>& triangles, const LayerSurfaces& targets,
                         const LayerFitOptions& options, LayerFitReport& report)
{
    check_options(options);
    const Eigen::Index count = targets.skin.rows(), num_triangles = triangles.rows();
    require(targets.bone.rows() == count && targets.muscle.rows() == count && num_triangles > 0,
            "layers were to be fitted to surfaces of {}, {} and {} vertices", targets.bone.rows(),
            targets.muscle.rows(), count);
    const auto neighbours = vertex_neighbours(triangles, static_cast<int>(count));
    const Surfaces wanted{targets.bone, targets.muscle, targets.skin};
    Surfaces at = wanted, best = wanted;
    Eigen::ArrayX2d weights = Eigen::ArrayX2d::Ones(num_triangles, 2);
    const Points normals = vertex_normals(targets.skin, triangles);
    std::vector<char> moved(count, 0);
    report = {};
    report.min_scaled_jacobian = -std::numeric_limits<double>::max();
    for (int round = 0;; ++round) {
        std::vector<char> bad(count, 0), invalid = bad;
        double lowest = std::numeric_limits<double>::max();
        int worst = -1, num_bad = 0;
        for (Eigen::Index t = 0; t < num_triangles; ++t)
            for (int layer = 0; layer < 2; ++layer) {
                const Eigen::RowVector3d quality = prism_quality(prism_of(at, triangles, t, layer));
                if (quality[0] < lowest) {
                    lowest = quality[0];
                    worst = static_cast<int>(t);
                }
                if (quality[0] >= surplus * options.min_scaled_jacobian && quality[1] >= options.min_thickness)
                    continue;
                ++num_bad;
                if (round > 0) weights(t, layer) = std::min(weight_growth * weights(t, layer), max_weight);
                for (int k = 0; k < 3; ++k) {
                    bad[triangles(t, k)] = 1;
                    if (quality[0] <= 0.0) invalid[triangles(t, k)] = 1;
                }
            }
        log_debug("layers: round {}, {} of {} prisms below what is wanted, smallest scaled Jacobian {:.4f}", round,
                  num_bad, 2 * num_triangles, lowest);
        if (lowest > report.min_scaled_jacobian || num_bad == 0) {
            report.min_scaled_jacobian = lowest;
            report.worst_triangle = worst;
            best = at;
        }
        report.rounds = round;
        if (num_bad == 0 || round == options.max_rounds) break;
        if (round > 0 && round % rounds_to_restart == 0 && lowest <= 0.0) {
            grow(invalid, neighbours, round / rounds_to_restart);
            restart_columns(invalid, targets.skin, normals, at);
        }
        grow(bad, neighbours, first_rings + round / 2);
        for (std::size_t v = 0; v < bad.size(); ++v) moved[v] = moved[v] || bad[v];
        relax(Patch(triangles, wanted, at, neighbours, options, weights, bad), at);
    }
    report.moved_vertices = static_cast<int>(std::count(moved.begin(), moved.end(), 1));
    const Eigen::VectorXd displacement = (best[2] - targets.skin).rowwise().norm();
    report.mean_skin_displacement = displacement.mean();
    report.max_skin_displacement = displacement.maxCoeff();
    return {std::move(best[0]), std::move(best[1]), std::move(best[2])};
}

}  // namespace ndg
