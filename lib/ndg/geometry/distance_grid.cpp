// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/distance_grid.h"

#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/nearest_seeds.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace ndg {
namespace {

/// Spacings beside a surface within which its signed distance is computed from the triangles themselves.
constexpr double exact_band = 3.0;

/// A surface beside a node.
struct NearPoint {
    Eigen::Vector3f point, normal;
    float squared_distance;
};

struct NearSurface {
    std::vector<int> entry_of_node;  ///< -1 for none
    std::vector<NearPoint> entries;
};

/// The closest point of the triangles for the nodes at most `band` spacings away from one (in each coordinate).
NearSurface rasterise(const GridBox& box, const Eigen::Ref<const Points>& vertices,
                      const Eigen::Ref<const Triangles>& triangles, double band)
{
    constexpr int slab_height = 16;
    const Points normals = vertex_normals(vertices, triangles);
    const Points scaled = (vertices.rowwise() - box.origin.transpose()) / box.spacing;
    NearSurface result;
    result.entry_of_node.assign(box.count(), -1);
    const int num_slabs = (box.size[2] + slab_height - 1) / slab_height;
    std::vector<std::vector<NearPoint>> slab_entries(num_slabs);
#pragma omp parallel for schedule(dynamic)
    for (int slab = 0; slab < num_slabs; ++slab) {
        auto& entries = slab_entries[slab];
        const int slab_begin = slab * slab_height;
        const int slab_end = std::min(box.size[2], slab_begin + slab_height);
        for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
            const Eigen::Vector3d a = scaled.row(triangles(t, 0)), b = scaled.row(triangles(t, 1)),
                                  c = scaled.row(triangles(t, 2));
            Eigen::Array3i low = (a.cwiseMin(b).cwiseMin(c).array() - band).ceil().cast<int>().max(0);
            Eigen::Array3i high =
                (a.cwiseMax(b).cwiseMax(c).array() + band).floor().cast<int>().min(Eigen::Array3i(box.size - 1));
            low[2] = std::max(low[2], slab_begin);
            high[2] = std::min(high[2], slab_end - 1);
            if ((low > high).any()) continue;
            for (int k = low[2]; k <= high[2]; ++k)
                for (int j = low[1]; j <= high[1]; ++j)
                    for (int i = low[0]; i <= high[0]; ++i) {
                        const Eigen::Vector3d node(i, j, k);
                        const ClosestPoint closest = closest_point_on_triangle(node, a, b, c);
                        if ((closest.point - node).cwiseAbs().maxCoeff() > band) continue;
                        const auto squared = static_cast<float>(closest.distance * closest.distance);
                        int& entry = result.entry_of_node[box.index(i, j, k)];
                        if (entry >= 0 && entries[entry].squared_distance <= squared) continue;
                        if (entry < 0) {
                            entry = static_cast<int>(entries.size());
                            entries.emplace_back();
                        }
                        const Eigen::RowVector3d normal = closest.barycentric.transpose() *
                                                          (Eigen::Matrix3d() << normals.row(triangles(t, 0)),
                                                           normals.row(triangles(t, 1)), normals.row(triangles(t, 2)))
                                                              .finished();
                        entries[entry] = {closest.point.cast<float>(), normal.transpose().cast<float>(), squared};
                    }
        }
    }
    for (int slab = 0; slab < num_slabs; ++slab) {
        const auto& entries = slab_entries[slab];
        const int shift = static_cast<int>(result.entries.size());
        const auto begin = static_cast<std::size_t>(box.index(0, 0, slab * slab_height));
        const auto end = static_cast<std::size_t>(box.index(0, 0, std::min(box.size[2], (slab + 1) * slab_height)));
        for (std::size_t n = begin; n < end; ++n)
            if (result.entry_of_node[n] >= 0) result.entry_of_node[n] += shift;
        result.entries.insert(result.entries.end(), entries.begin(), entries.end());
    }
    require(!result.entries.empty(), "no triangle reaches into the distance grid");
    return result;
}

/// The near points that lie in the cube of their own node.
SeedGrid seeds_of(const GridBox& box, const NearSurface& near)
{
    SeedGrid seeds;
    seeds.seed_of_node.assign(near.entry_of_node.size(), -1);
    for (int k = 0; k < box.size[2]; ++k)
        for (int j = 0; j < box.size[1]; ++j)
            for (int i = 0; i < box.size[0]; ++i) {
                const auto n = static_cast<std::size_t>(box.index(i, j, k));
                if (near.entry_of_node[n] < 0) continue;
                const NearPoint& entry = near.entries[near.entry_of_node[n]];
                if ((entry.point - Eigen::Vector3f(i, j, k)).cwiseAbs().maxCoeff() > 0.5F) continue;
                seeds.seed_of_node[n] = static_cast<int>(seeds.points.size());
                seeds.points.push_back(entry.point);
                seeds.normals.push_back(entry.normal);
            }
    require(!seeds.points.empty(), "no triangle reaches into the distance grid");
    return seeds;
}

float seed_distance(const SeedGrid& seeds, std::size_t n, int i, int j, int k)
{
    return (seeds.points[seeds.seed_of_node[n]] - Eigen::Vector3f(i, j, k)).norm();
}

/// 1 for the nodes that can be reached from the grid's faces through nodes farther than `radius` (in spacings).
std::vector<std::uint8_t> reach_from_outside(const GridBox& box, const std::vector<float>& distance, float radius)
{
    std::vector<std::uint8_t> reached(distance.size(), 0);
    std::vector<Eigen::Index> open;
    const auto visit = [&](int i, int j, int k) {
        const auto n = static_cast<std::size_t>(box.index(i, j, k));
        if (reached[n] || distance[n] < radius) return;
        reached[n] = 1;
        open.push_back(static_cast<Eigen::Index>(n));
    };
    for (int k = 0; k < box.size[2]; ++k)
        for (int j = 0; j < box.size[1]; ++j)
            for (int i = 0; i < box.size[0]; ++i) {
                const bool on_face = k == 0 || j == 0 || k == box.size[2] - 1 || j == box.size[1] - 1;
                if (on_face || i == 0 || i == box.size[0] - 1) visit(i, j, k);
            }
    while (!open.empty()) {
        const Eigen::Index n = open.back();
        open.pop_back();
        const int i = static_cast<int>(n % box.size[0]);
        const int j = static_cast<int>((n / box.size[0]) % box.size[1]);
        const int k = static_cast<int>(n / (Eigen::Index(box.size[0]) * box.size[1]));
        if (i > 0) visit(i - 1, j, k);
        if (i + 1 < box.size[0]) visit(i + 1, j, k);
        if (j > 0) visit(i, j - 1, k);
        if (j + 1 < box.size[1]) visit(i, j + 1, k);
        if (k > 0) visit(i, j, k - 1);
        if (k + 1 < box.size[2]) visit(i, j, k + 1);
    }
    return reached;
}

/// Points of the level set distance = radius that face the reached nodes.
SeedGrid level_set_seeds(const GridBox& box, const SeedGrid& surface, const std::vector<float>& distance,
                         const std::vector<std::uint8_t>& reached, float radius)
{
    SeedGrid seeds;
    seeds.seed_of_node.assign(distance.size(), -1);
    const auto inside = [&](int i, int j, int k) { return !reached[box.index(i, j, k)]; };
    for (int k = 1; k + 1 < box.size[2]; ++k)
        for (int j = 1; j + 1 < box.size[1]; ++j)
            for (int i = 1; i + 1 < box.size[0]; ++i) {
                const auto n = static_cast<std::size_t>(box.index(i, j, k));
                if (distance[n] < radius - 1.8F || distance[n] > radius + 1.8F) continue;
                const bool in = inside(i, j, k);
                if (in == inside(i - 1, j, k) && in == inside(i + 1, j, k) && in == inside(i, j - 1, k) &&
                    in == inside(i, j + 1, k) && in == inside(i, j, k - 1) && in == inside(i, j, k + 1))
                    continue;
                const Eigen::Vector3f& centre = surface.points[surface.seed_of_node[n]];
                const Eigen::Vector3f node(i, j, k);
                const Eigen::Vector3f point = centre + (radius / distance[n]) * (node - centre);
                const Eigen::Array3i home = point.array().round().cast<int>();
                if ((home < 0).any() || (home >= box.size).any()) continue;
                const auto h = static_cast<std::size_t>(box.index(home[0], home[1], home[2]));
                // A point that another triangle is nearer to lies within the dilated set, not on its border.
                const float nearest = (surface.points[surface.seed_of_node[h]] - point).norm();
                if (nearest < radius - 0.05F) continue;
                int& seed = seeds.seed_of_node[h];
                const Eigen::Vector3f cube = home.cast<float>().matrix();
                if (seed < 0) {
                    seed = static_cast<int>(seeds.points.size());
                    seeds.points.push_back(point);
                } else if ((point - cube).squaredNorm() < (seeds.points[seed] - cube).squaredNorm()) {
                    seeds.points[seed] = point;
                }
            }
    require(!seeds.points.empty(), "the distance grid is too small for a closing by {} spacings", radius);
    return seeds;
}

}  // namespace

GridBox grid_around(const Eigen::Ref<const Points>& points, double margin, double spacing)
{
    require(points.rows() > 0 && spacing > 0.0 && margin >= 0.0, "a grid needs points and a positive spacing");
    const Eigen::Vector3d low = points.colwise().minCoeff().transpose().array() - margin;
    const Eigen::Vector3d high = points.colwise().maxCoeff().transpose().array() + margin;
    GridBox box;
    box.spacing = spacing;
    box.origin = low;
    box.size = ((high - low) / spacing).array().ceil().cast<int>() + 1;
    require((box.size.cast<double>()).prod() < 1.0e9, "a grid of {} x {} x {} nodes is too large", box.size[0],
            box.size[1], box.size[2]);
    return box;
}

double ScalarGrid::at(const Eigen::Vector3d& point, Eigen::Vector3d* gradient) const
{
    const Eigen::Array3d scaled = (point - box.origin).array() / box.spacing;
    const Eigen::Array3d limit = (box.size - 1).cast<double>();
    const Eigen::Array3d clamped = scaled.max(0.0).min(limit);
    const Eigen::Array3i base = clamped.floor().cast<int>().min(Eigen::Array3i(box.size - 2)).max(0);
    const Eigen::Array3d f = clamped - base.cast<double>();
    const float* corner = values.data() + box.index(base[0], base[1], base[2]);
    const Eigen::Index dy = box.size[0], dz = dy * box.size[1];
    const double v000 = corner[0], v100 = corner[1], v010 = corner[dy], v110 = corner[dy + 1];
    const double v001 = corner[dz], v101 = corner[dz + 1], v011 = corner[dz + dy], v111 = corner[dz + dy + 1];
    const double x00 = v000 + f[0] * (v100 - v000), x10 = v010 + f[0] * (v110 - v010);
    const double x01 = v001 + f[0] * (v101 - v001), x11 = v011 + f[0] * (v111 - v011);
    const double y0 = x00 + f[1] * (x10 - x00), y1 = x01 + f[1] * (x11 - x01);
    if (gradient != nullptr) {
        const double dx0 = (v100 - v000) + f[1] * ((v110 - v010) - (v100 - v000));
        const double dx1 = (v101 - v001) + f[1] * ((v111 - v011) - (v101 - v001));
        *gradient =
            Eigen::Vector3d(dx0 + f[2] * (dx1 - dx0), (x10 - x00) + f[2] * ((x11 - x01) - (x10 - x00)), y1 - y0) /
            box.spacing;
        for (int axis = 0; axis < 3; ++axis)
            if (scaled[axis] < 0.0 || scaled[axis] > limit[axis]) (*gradient)[axis] = 0.0;
    }
    return y0 + f[2] * (y1 - y0);
}

ScalarGrid signed_distance_grid(const GridBox& box, const Eigen::Ref<const Points>& vertices,
                                const Eigen::Ref<const Triangles>& triangles)
{
    const NearSurface near = rasterise(box, vertices, triangles, exact_band);
    SeedGrid seeds = seeds_of(box, near);
    find_nearest_seeds(box, seeds);
    ScalarGrid result{box, std::vector<float>(near.entry_of_node.size())};
    for_each_node(box, [&](int i, int j, int k, std::size_t n) {
        const Eigen::Vector3f node(i, j, k);
        const auto seed = static_cast<std::size_t>(seeds.seed_of_node[n]);
        Eigen::Vector3f point = seeds.points[seed], normal = seeds.normals[seed];
        if (near.entry_of_node[n] >= 0) {
            const NearPoint& entry = near.entries[near.entry_of_node[n]];
            if (entry.squared_distance <= (node - point).squaredNorm()) {
                point = entry.point;
                normal = entry.normal;
            }
        }
        const float distance = (node - point).norm() * static_cast<float>(box.spacing);
        result.values[n] = (node - point).dot(normal) < 0.0F ? -distance : distance;
    });
    return result;
}

ScalarGrid closing_grid(const GridBox& box, const Eigen::Ref<const Points>& vertices,
                        const Eigen::Ref<const Triangles>& triangles, double radius)
{
    const auto scaled_radius = static_cast<float>(radius / box.spacing);
    ScalarGrid result{box, {}};
    SeedGrid level;
    std::vector<std::uint8_t> reached;
    {
        SeedGrid surface = seeds_of(box, rasterise(box, vertices, triangles, 0.5));
        find_nearest_seeds(box, surface);
        result.values.resize(surface.seed_of_node.size());
        for_each_node(
            box, [&](int i, int j, int k, std::size_t n) { result.values[n] = seed_distance(surface, n, i, j, k); });
        reached = reach_from_outside(box, result.values, scaled_radius);
        level = level_set_seeds(box, surface, result.values, reached, scaled_radius);
    }
    find_nearest_seeds(box, level);
    const auto spacing = static_cast<float>(box.spacing);
    for_each_node(box, [&](int i, int j, int k, std::size_t n) {
        const float distance = seed_distance(level, n, i, j, k);
        result.values[n] = spacing * (reached[n] ? scaled_radius + distance : scaled_radius - distance);
    });
    return result;
}

}  // namespace ndg
