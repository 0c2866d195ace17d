// SPDX-License-Identifier: Apache-2.0
#include "ndg/procedural/surface.h"

#include "ndg/core/error.h"
#include "ndg/geometry/isosurface.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

constexpr int newton_steps = 12;
constexpr int meshing_rounds = 4;
constexpr int smoothing_steps = 16;

/// Planes from the first to the last knot; knot i: spacing from its place to the next one's.
std::vector<double> graded_axis(const std::vector<std::pair<double, double>>& knots)
{
    std::vector<double> planes;
    for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
        const double length = knots[i + 1].first - knots[i].first;
        const int steps = std::max(1, static_cast<int>(std::ceil(length / knots[i].second)));
        for (int s = 0; s < steps; ++s) planes.push_back(knots[i].first + length * s / steps);
    }
    planes.push_back(knots.back().first);
    return planes;
}

void project_all(Points& half, int num_middle, const Field& field)
{
#pragma omp parallel for schedule(dynamic, 256)
    for (Eigen::Index v = 0; v < half.rows(); ++v) {
        Eigen::Vector3d x = field.project(half.row(v).transpose(), 0.0, newton_steps);
        if (v < num_middle) x.x() = 0.0;
        half.row(v) = x.transpose();
    }
}

/// Neighbours of the left half's vertices; one across the middle is the mirror image of a vertex of the half.
struct HalfNeighbour {
    int vertex;
    bool mirrored;
};
std::vector<std::vector<HalfNeighbour>> half_neighbours(const SymmetricSurface& surface)
{
    const auto all = vertex_neighbours(surface.triangles, static_cast<int>(surface.vertices.rows()));
    std::vector<std::vector<HalfNeighbour>> result(surface.num_half);
    for (std::size_t v = 0; v < result.size(); ++v)
        for (const int n : all[v]) {
            const bool mirrored = n >= surface.num_half;
            result[v].push_back({mirrored ? n - surface.num_half + surface.num_middle : n, mirrored});
        }
    return result;
}

/// Mean of a field of vectors over the neighbours of every vertex, symmetric in x.
Points neighbour_mean(const std::vector<std::vector<HalfNeighbour>>& neighbours, const Points& values)
{
    Points mean(values.rows(), 3);
#pragma omp parallel for
    for (Eigen::Index v = 0; v < values.rows(); ++v) {
        Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
        for (const HalfNeighbour& n : neighbours[v]) {
            Eigen::RowVector3d value = values.row(n.vertex);
            if (n.mirrored) value.x() = -value.x();
            sum += value;
        }
        mean.row(v) = sum / static_cast<double>(neighbours[v].size());
    }
    return mean;
}

}  // namespace

Points SymmetricSurface::complete(const Eigen::Ref<const Points>& half) const
{
    require(half.rows() == num_half, "Half of a symmetric surface has {} vertices instead of {}", half.rows(),
            num_half);
    Points all(2 * num_half - num_middle, 3);
    all.topRows(num_half) = half;
    all.bottomRows(num_half - num_middle) = half.bottomRows(num_half - num_middle);
    all.bottomRows(num_half - num_middle).col(0) *= -1.0;
    return all;
}

SymmetricSurface mesh_skin(const BodyLayout& layout, const Field& field)
{
    const double u = layout.unit();
    const Eigen::Vector3d wrist = layout.joint("left_hand"), neck = layout.joint("neck_2"),
                          toes = layout.joint("left_toes");
    const double hand_x = wrist.x() - 0.01 * u, hand_low = wrist.y() - 0.20 * u;
    const double foot_high = layout.joint("left_foot").y() - 0.01 * u, head_low = neck.y() - 0.01 * u;
    GridAxes axes;
    axes.x = graded_axis({{0.0, 0.0038 * u},
                          {0.09 * u, 0.0065 * u},
                          {0.24 * u, 0.011 * u},
                          {hand_x, 0.0035 * u},
                          {hand_x + 0.24 * u, 0.0}});
    axes.y = graded_axis({{-0.02 * u, 0.0055 * u},
                          {foot_high, 0.011 * u},
                          {hand_low, 0.0055 * u},
                          {wrist.y(), 0.011 * u},
                          {head_low, 0.0038 * u},
                          {head_low + 0.15 * u, 0.006 * u},
                          {layout.parameters().stature_m + 0.03 * u, 0.0}});
    axes.z = graded_axis(
        {{-0.22 * u, 0.0065 * u}, {-0.03 * u, 0.0045 * u}, {0.13 * u, 0.0065 * u}, {toes.z() + 0.12 * u, 0.0}});
    TriangleMesh mesh = marching_tetrahedra([&](const Eigen::Vector3d& x) { return field.value(x); }, axes);

    // Coarse to fine: the finer regions then own the borders.
    enum Region : int { body_region, head_region, foot_region, hand_region, face_region };
    const std::vector<double> edge_lengths = {0.0142 * u, 0.0080 * u, 0.0066 * u, 0.0048 * u, 0.0034 * u};
    const Eigen::Vector3d eye = layout.joint("left_eye");
    const auto region = [&](const Eigen::Vector3d& c) {
        if ((c - wrist).dot(layout.arm_axis()) > 0.0 && c.x() > hand_x - 0.05 * u) return hand_region;
        if (c.y() < foot_high) return foot_region;
        if (c.y() < head_low + 0.3 * u * c.z()) return body_region;
        const double above_eye = (c.y() - eye.y()) / u;
        const bool face = c.z() > 0.048 * u && c.x() < 0.058 * u && above_eye > -0.085 && above_eye < 0.022;
        const bool ear = c.x() > 0.071 * u && above_eye > -0.055 && above_eye < 0.030;
        return face || ear ? face_region : head_region;
    };
    std::vector<int> labels;
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
        Eigen::Vector3d centre = Eigen::Vector3d::Zero();
        for (int k = 0; k < 3; ++k) centre += mesh.vertices.row(mesh.triangles(t, k)).transpose() / 3.0;
        labels.push_back(region(centre));
    }
    mesh = remesh_graded(mesh, labels, edge_lengths);

    // Middle vertices first.
    std::vector<int> order, rank(static_cast<std::size_t>(mesh.vertices.rows()));
    SymmetricSurface surface;
    for (const bool middle : {true, false}) {
        for (int v = 0; v < mesh.vertices.rows(); ++v)
            if ((mesh.vertices(v, 0) < 1e-12) == middle) order.push_back(v);
        if (middle) surface.num_middle = static_cast<int>(order.size());
    }
    surface.num_half = static_cast<int>(order.size());
    Points half(surface.num_half, 3);
    for (int i = 0; i < surface.num_half; ++i) {
        rank[order[i]] = i;
        half.row(i) = mesh.vertices.row(order[i]);
    }
    const Eigen::Index count = mesh.triangles.rows();
    surface.triangles.resize(2 * count, 3);
    const auto mirror = [&](int v) { return v < surface.num_middle ? v : v + surface.num_half - surface.num_middle; };
    for (Eigen::Index t = 0; t < count; ++t)
        for (int k = 0; k < 3; ++k) {
            const int v = rank[mesh.triangles(t, k)];
            surface.triangles(t, k) = v;
            surface.triangles(count + t, 2 - k) = mirror(v);
        }
    surface.vertices = surface.complete(half);
    half = settle_on_skin(surface, half, field, meshing_rounds);
    surface.vertices = surface.complete(half);
    return surface;
}

Points settle_on_skin(const SymmetricSurface& surface, const Eigen::Ref<const Points>& carried, const Field& field,
                      int rounds)
{
    const auto neighbours = half_neighbours(surface);
    Points x = carried;
    project_all(x, surface.num_middle, field);
    for (int round = 0; round < rounds; ++round) {
        Points displacement = x - carried;
        for (int step = 0; step < smoothing_steps; ++step)
            displacement = 0.5 * displacement + 0.5 * neighbour_mean(neighbours, displacement);
        x = carried + displacement;
        project_all(x, surface.num_middle, field);
    }
    return x;
}

}  // namespace ndg
