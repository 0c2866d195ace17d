// SPDX-License-Identifier: Apache-2.0
#include "ndg/body_source/skin_depth.h"

#include "ndg/core/error.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace ndg {
namespace {

/// A grid around the skin with a margin of air.
struct Grid {
    Eigen::Vector3d origin;
    Eigen::Vector3i size;
    double cell;
    std::vector<std::uint8_t> states;  // 0 unknown, 1 skin, 2 outside air

    std::size_t index(const Eigen::Vector3i& c) const
    {
        return (std::size_t(c[2]) * std::size_t(size[1]) + std::size_t(c[1])) * std::size_t(size[0]) +
               std::size_t(c[0]);
    }
    Eigen::Vector3i cell_of(const Eigen::Vector3d& point) const
    {
        return ((point - origin) / cell).array().floor().cast<int>();
    }
    bool contains(const Eigen::Vector3i& c) const { return (c.array() >= 0).all() && (c.array() < size.array()).all(); }
};

/// Calls `visit` for points of a triangle not farther apart than `step`.
template <typename Visit>
void sample_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, double step,
                     const Visit& visit)
{
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    const int pieces = int(std::clamp(std::ceil(longest / step), 1.0, 1e4));
    for (int i = 0; i <= pieces; ++i)
        for (int j = 0; i + j <= pieces; ++j)
            visit(Eigen::Vector3d(a + (b - a) * (double(i) / pieces) + (c - a) * (double(j) / pieces)));
}

void flood(Grid& grid)
{
    std::vector<Eigen::Vector3i> front = {Eigen::Vector3i::Zero()};
    grid.states[0] = 2;
    while (!front.empty()) {
        const Eigen::Vector3i c = front.back();
        front.pop_back();
        for (int k = 0; k < 3; ++k)
            for (const int step : {-1, 1}) {
                Eigen::Vector3i next = c;
                next[k] += step;
                if (!grid.contains(next) || grid.states[grid.index(next)] != 0) continue;
                grid.states[grid.index(next)] = 2;
                front.push_back(next);
            }
    }
}

Triangles select(const Eigen::Ref<const Triangles>& triangles, const std::vector<int>& chosen)
{
    Triangles result(static_cast<Eigen::Index>(chosen.size()), 3);
    for (std::size_t i = 0; i < chosen.size(); ++i) result.row(Eigen::Index(i)) = triangles.row(chosen[i]);
    return result;
}

}  // namespace

struct OuterAir::State {
    Grid grid;
    std::vector<int> triangles;
};

OuterAir::OuterAir(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles, double cell)
    : state_(std::make_unique<State>())
{
    require(vertices.rows() > 0 && cell > 0.0, "an empty skin has no outside");
    const Eigen::Vector3d low = vertices.colwise().minCoeff(), high = vertices.colwise().maxCoeff();
    Grid& grid = state_->grid;
    grid.cell = cell;
    grid.origin = low.array() - 2.5 * cell;
    grid.size = ((high - grid.origin) / cell).array().ceil().cast<int>() + 3;
    const double cells = grid.size.cast<double>().prod();
    require(cells < 4e8, "the skin spans {:.0f} cells of {} m, is it in metres?", cells, cell);
    grid.states.assign(std::size_t(cells), 0);
    const auto corner = [&](Eigen::Index t, int k) { return Eigen::Vector3d(vertices.row(triangles(t, k))); };
    for (Eigen::Index t = 0; t < triangles.rows(); ++t)
        sample_triangle(corner(t, 0), corner(t, 1), corner(t, 2), 0.5 * cell,
                        [&](const Eigen::Vector3d& point) { grid.states[grid.index(grid.cell_of(point))] = 1; });
    flood(grid);
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        bool reached = false;
        sample_triangle(corner(t, 0), corner(t, 1), corner(t, 2), 0.5 * cell,
                        [&](const Eigen::Vector3d& point) { reached = reached || reaches(point); });
        if (reached) state_->triangles.push_back(int(t));
    }
}

OuterAir::~OuterAir() = default;

const std::vector<int>& OuterAir::triangles() const
{
    return state_->triangles;
}

bool OuterAir::reaches(const Eigen::Vector3d& point) const
{
    const Grid& grid = state_->grid;
    const Eigen::Vector3i cell = grid.cell_of(point);
    if (!grid.contains(cell)) return true;
    for (int k = 0; k < 27; ++k) {
        const Eigen::Vector3i next = cell + Eigen::Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
        if (grid.contains(next) && grid.states[grid.index(next)] == 2) return true;
    }
    return false;
}

SkinDepth::SkinDepth(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles)
    : air_(vertices, triangles), closed_(vertices, triangles), outer_(vertices, select(triangles, air_.triangles()))
{
}

SkinDepth::Result SkinDepth::at(const Eigen::Vector3d& point, bool hollow) const
{
    ClosestPoint nearest;
    Result result;
    result.depth = -closed_.signed_distance(point, &nearest);
    if (!hollow) {
        const bool outside = result.depth < 0.0 && air_.reaches(point);
        nearest = outer_.closest(point);
        result.depth = outside ? -nearest.distance : nearest.distance;
    }
    result.point = nearest.point;
    const Eigen::Vector3d offset = point - nearest.point;
    const double length = offset.norm();
    // On the skin itself the direction is lost; such a point is asked for again a little further in.
    if (length > 1e-9) result.inward = offset * ((result.depth >= 0.0 ? 1.0 : -1.0) / length);
    return result;
}

double SkinDepth::room_at(const Result& nearest, double reach, bool hollow) const
{
    // Depth grows by one along the way until the middle of the body, so the whole reach is tried first.
    constexpr int steps = 4;
    double room = 0.0;
    for (int i = steps; i >= 1; --i) {
        const double way = reach * i / steps;
        const double depth = at(nearest.point + way * nearest.inward, hollow).depth;
        room = std::max(room, depth);
        if (depth > 0.95 * way) break;
    }
    return room;
}

double SkinDepth::cover_at(const Result& nearest, double cover, bool hollow) const
{
    const double reach = 2.5 * cover, room = room_at(nearest, reach, hollow);
    // On a facetted skin depth grows a little slower than the way.
    return room > 0.95 * reach ? cover : std::clamp(0.4 * room, 0.2 * cover, cover);
}

}  // namespace ndg
