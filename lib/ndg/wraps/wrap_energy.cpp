// SPDX-License-Identifier: Apache-2.0
#include "ndg/wraps/wrap_energy.h"

#include "ndg/core/error.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/wraps/prism_barrier.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

namespace ndg {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
/// Fewer triangles are not worth waking threads for.
constexpr Eigen::Index min_parallel = 2000;

/// Umbrella Laplacian in 1/m^2 (4 (mean - x) / edge^2 on a regular mesh); border vertices look along the border only.
Eigen::SparseMatrix<double> surface_laplacian(const WrapSkin& skin, const std::vector<std::vector<int>>& loops)
{
    const int count = static_cast<int>(skin.vertices.rows());
    auto neighbours = vertex_neighbours(skin.triangles, count);
    std::vector<double> factor(count, 4.0);
    for (const auto& loop : loops)
        for (std::size_t i = 0; i < loop.size(); ++i) {
            neighbours[loop[i]] = {loop[(i + 1) % loop.size()], loop[(i + loop.size() - 1) % loop.size()]};
            factor[loop[i]] = 2.0;
        }
    std::vector<Eigen::Triplet<double>> entries;
    for (int v = 0; v < count; ++v) {
        const auto& ring = neighbours[v];
        double squared = 0.0;
        for (const int n : ring) squared += (skin.vertices.row(n) - skin.vertices.row(v)).squaredNorm();
        const double weight = factor[v] / squared;
        for (const int n : ring) entries.emplace_back(v, n, weight);
        entries.emplace_back(v, v, -weight * static_cast<double>(ring.size()));
    }
    Eigen::SparseMatrix<double> laplacian(count, count);
    laplacian.setFromTriplets(entries.begin(), entries.end());
    return laplacian;
}

}  // namespace

WrapEnergy::WrapEnergy(const WrapSkin& skin, const ScalarGrid& bone, const ScalarGrid& muscle,
                       const ScalarGrid& skin_distance, const WrapEnergyOptions& energy_options)
    : options(energy_options), skin_(skin), bone_(bone), muscle_(muscle), skin_distance_(skin_distance)
{
    const Eigen::Index num_triangles = skin.triangles.rows();
    const int count = static_cast<int>(skin.vertices.rows());
    triangle_weights_ = triangle_areas(skin.vertices, skin.triangles);
    const double mean_area = triangle_weights_.mean();
    triangle_weights_ /= mean_area;
    mean_area_ = mean_area;
    jacobian_bounds = Eigen::ArrayX2d::Zero(num_triangles, 2);
    thickness_bounds = Eigen::ArrayX2d::Zero(num_triangles, 2);
    margins = Eigen::ArrayX2d::Zero(num_triangles, 2);

    incident_.resize(count);
    double edge = 0.0;
    for (Eigen::Index t = 0; t < num_triangles; ++t)
        for (int k = 0; k < 3; ++k) {
            incident_[skin.triangles(t, k)].push_back({static_cast<int>(t), k});
            edge +=
                (skin.vertices.row(skin.triangles(t, k)) - skin.vertices.row(skin.triangles(t, (k + 1) % 3))).norm() /
                (3.0 * static_cast<double>(num_triangles));
        }
    const int division = std::clamp(static_cast<int>(std::ceil(edge / options.sample_spacing)), 2, 12);
    for (int i = 0; i <= division; ++i)
        for (int j = 0; i + j <= division; ++j) samples_.push_back(Eigen::Vector3d(i, j, division - i - j) / division);

    const auto loops = boundary_loops(skin.triangles, count);
    for (const auto& loop : loops) {
        Points points(static_cast<Eigen::Index>(loop.size()), 3);
        for (std::size_t i = 0; i < loop.size(); ++i)
            points.row(static_cast<Eigen::Index>(i)) = skin.vertices.row(loop[i]);
        const Eigen::RowVector3d centre = points.colwise().mean();
        const Points centred = points.rowwise() - centre;
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(centred.transpose() * centred);
        // A vertex keeps the height over the plane that its skin vertex has.
        for (const int v : loop) border_.push_back({v, skin.vertices.row(v), axes.eigenvectors().col(0).transpose()});
    }

    const Eigen::SparseMatrix<double> laplacian = surface_laplacian(skin, loops);
    const Eigen::VectorXd areas = vertex_areas(skin.vertices, skin.triangles) / mean_area;
    const Eigen::SparseMatrix<double> squared = laplacian.transpose() * areas.asDiagonal() * laplacian;
    const double unit = 1.0 / (options.length_scale * options.length_scale);
    bone_bending_ = unit * std::pow(options.bone_bending_length, 4) * squared;
    muscle_bending_ = unit * std::pow(options.muscle_bending_length, 4) * squared;
    prepare_pattern();
}

BarrierBounds WrapEnergy::bounds(Eigen::Index t, int layer) const
{
    const double area = 2.0 * mean_area_ * triangle_weights_[t];
    return {jacobian_bounds(t, layer), options.active_jacobian, thickness_bounds(t, layer),
            options.active_thickness,  options.min_area * area, options.active_area * area};
}

WrapEnergy::Corners WrapEnergy::corners(const Points& surface, Eigen::Index t) const
{
    Corners triangle;
    for (int k = 0; k < 3; ++k) triangle.row(k) = surface.row(skin_.triangles(t, k));
    return triangle;
}

double WrapEnergy::fit(const ScalarGrid& envelope, double margin, double depth, double weight, const Corners& triangle,
                       Corners* gradient, Eigen::Matrix<double, 9, 9>* hessian) const
{
    double energy = 0.0;
    const double scale = weight / (options.length_scale * options.length_scale * static_cast<double>(samples_.size()));
    // Quadratic, and linear where a wrap is deep inside, so that no force crushes the prisms beside it.
    const auto add = [&](double gap, double stiffness, const Eigen::Vector3d& sample, const Eigen::Vector3d& slope) {
        const double reach = std::max(gap, -options.repulsion_reach);
        energy += stiffness * reach * (2.0 * gap - reach);
        if (gradient != nullptr) *gradient += 2.0 * stiffness * reach * sample * slope.transpose();
        if (hessian == nullptr || gap == 0.0) return;
        const Eigen::Matrix3d normal = 2.0 * stiffness * (reach / gap) * slope * slope.transpose();
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b) hessian->block<3, 3>(3 * a, 3 * b) += sample[a] * sample[b] * normal;
    };
    for (const Eigen::Vector3d& sample : samples_) {
        Eigen::Vector3d slope = Eigen::Vector3d::Zero();
        const Eigen::Vector3d point = triangle.transpose() * sample;
        const bool derive = gradient != nullptr || hessian != nullptr;
        const double gap = envelope.at(point, derive ? &slope : nullptr) - margin;
        add(gap, scale * (gap < 0.0 ? options.repulsion : 1.0), sample, slope);
        const double cover = -skin_distance_.at(point, derive ? &slope : nullptr) - depth;
        if (cover < 0.0) add(cover, scale * options.repulsion, sample, -slope);
    }
    return energy;
}

void WrapEnergy::limit_move(const WrapPair& wraps, WrapPair& move) const
{
    constexpr int max_rounds = 25;
    constexpr double shortening = 0.6;
    constexpr double keep = 0.15;  ///< of the way to a bound that must be left
    const Eigen::Index num_triangles = skin_.triangles.rows();
    const auto prism = [&](const WrapPair& state, Eigen::Index t, int layer) {
        PrismVertices result;
        result << (layer == 0 ? corners(skin_.vertices, t) : corners(state.muscle, t)),
            (layer == 0 ? corners(state.muscle, t) : corners(state.bone, t));
        return result;
    };
    std::vector<int> candidates(num_triangles);
    std::iota(candidates.begin(), candidates.end(), 0);
    std::vector<char> bad(candidates.size());
    WrapPair moved{wraps.bone + move.bone, wraps.muscle + move.muscle};
    for (int round = 0; round < max_rounds && !candidates.empty(); ++round) {
        bad.assign(candidates.size(), 0);
#pragma omp parallel for schedule(static) if (candidates.size() > static_cast <std::size_t>(min_parallel))
        for (std::size_t c = 0; c < candidates.size(); ++c)
            for (int layer = 0; layer < 2; ++layer) {
                const Eigen::Index t = candidates[c];
                const BarrierBounds limit = bounds(t, layer);
                const Eigen::Array3d least(limit.jacobian, limit.thickness, limit.area);
                const Eigen::Array3d after = prism_quality(prism(moved, t, layer)).transpose().array() - least;
                // Most prisms are far from any bound.
                if ((after > least * 4.0).all()) continue;
                const Eigen::Array3d before = prism_quality(prism(wraps, t, layer)).transpose().array() - least;
                if ((after < keep * before).any()) bad[c] = 1;
            }
        std::set<int> shortened;
        for (std::size_t c = 0; c < candidates.size(); ++c)
            for (int k = 0; k < 3 && bad[c]; ++k) shortened.insert(skin_.triangles(candidates[c], k));
        std::set<int> touched;
        for (const int v : shortened) {
            move.bone.row(v) *= shortening;
            move.muscle.row(v) *= shortening;
            moved.bone.row(v) = wraps.bone.row(v) + move.bone.row(v);
            moved.muscle.row(v) = wraps.muscle.row(v) + move.muscle.row(v);
            for (const auto& [t, k] : incident_[v]) touched.insert(t);
        }
        candidates.assign(touched.begin(), touched.end());
    }
}

Points WrapEnergy::gather(const std::vector<Corners>& corner_gradients) const
{
    Points result = Points::Zero(skin_.vertices.rows(), 3);
    for (Eigen::Index v = 0; v < result.rows(); ++v)
        for (const auto& [t, k] : incident_[v]) result.row(v) += corner_gradients[t].row(k);
    return result;
}

double WrapEnergy::evaluate(const WrapPair& wraps, WrapPair* gradient) const
{
    const Eigen::Index num_triangles = skin_.triangles.rows();
    Eigen::VectorXd energies(num_triangles);
    std::vector<Corners> by_bone, by_muscle;
    if (gradient != nullptr) {
        by_bone.assign(num_triangles, Corners::Zero());
        by_muscle = by_bone;
    }
    // Barriers first: they are cheap, and an invalid state needs nothing else.
#pragma omp parallel for schedule(static) if (num_triangles > min_parallel)
    for (Eigen::Index t = 0; t < num_triangles; ++t) {
        const Corners b = corners(wraps.bone, t), m = corners(wraps.muscle, t), s = corners(skin_.vertices, t);
        PrismVertices fat, flesh, fat_gradient = PrismVertices::Zero(), flesh_gradient = PrismVertices::Zero();
        fat << s, m;
        flesh << m, b;
        const bool derive = gradient != nullptr;
        energies[t] = options.quality * prism_barrier(fat, bounds(t, 0), derive ? &fat_gradient : nullptr, nullptr) +
                      options.quality * prism_barrier(flesh, bounds(t, 1), derive ? &flesh_gradient : nullptr, nullptr);
        if (!derive) continue;
        by_muscle[t] += options.quality * (fat_gradient.bottomRows<3>() + flesh_gradient.topRows<3>());
        by_bone[t] += options.quality * flesh_gradient.bottomRows<3>();
    }
    double energy = energies.sum();
    if (!std::isfinite(energy)) return infinity;
#pragma omp parallel for schedule(static) if (num_triangles > min_parallel)
    for (Eigen::Index t = 0; t < num_triangles; ++t) {
        const Corners b = corners(wraps.bone, t), m = corners(wraps.muscle, t);
        const bool derive = gradient != nullptr;
        energies[t] = fit(bone_, margins(t, 0), 2.0 * options.cover, triangle_weights_[t], b,
                          derive ? &by_bone[t] : nullptr, nullptr) +
                      fit(muscle_, margins(t, 1), options.cover, options.muscle_fit * triangle_weights_[t], m,
                          derive ? &by_muscle[t] : nullptr, nullptr);
    }
    energy += energies.sum();

    // (1 - s) x K x + s (x - S) K (x - S), up to a constant
    const Points bone_shape = wraps.bone - options.skin_likeness * skin_.vertices;
    const Points muscle_shape = wraps.muscle - options.skin_likeness * skin_.vertices;
    const Points bone_force = bone_bending_ * bone_shape, muscle_force = muscle_bending_ * muscle_shape;
    energy += bone_shape.cwiseProduct(bone_force).sum() + muscle_shape.cwiseProduct(muscle_force).sum();
    if (gradient != nullptr) {
        gradient->bone = gather(by_bone) + 2.0 * bone_force;
        gradient->muscle = gather(by_muscle) + 2.0 * muscle_force;
    }
    const double border_scale = options.boundary / (options.length_scale * options.length_scale);
    for (const Border& border : border_) {
        const double bone_gap = (wraps.bone.row(border.vertex) - border.point).dot(border.normal);
        const double muscle_gap = (wraps.muscle.row(border.vertex) - border.point).dot(border.normal);
        energy += border_scale * (bone_gap * bone_gap + muscle_gap * muscle_gap);
        if (gradient == nullptr) continue;
        gradient->bone.row(border.vertex) += 2.0 * border_scale * bone_gap * border.normal;
        gradient->muscle.row(border.vertex) += 2.0 * border_scale * muscle_gap * border.normal;
    }
    return energy;
}

}  // namespace ndg
