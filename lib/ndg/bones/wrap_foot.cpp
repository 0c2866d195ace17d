// SPDX-License-Identifier: Apache-2.0
#include "ndg/bones/wrap_foot.h"

#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

Eigen::Vector3f corner(const PointColumnsF& wrap, int v)
{
    return wrap.col(v).head<3>();
}

Eigen::Vector3f area_normal(const SurfaceNeighbours& surface, const PointColumnsF& wrap, int t)
{
    const auto triangle = surface.triangles.row(t);
    const Eigen::Vector3f a = corner(wrap, triangle[0]);
    return (corner(wrap, triangle[1]) - a).cross(corner(wrap, triangle[2]) - a);
}

constexpr double on_edge = 1e-6;  ///< barycentric

/// The place nearest to a point as found by going down over the wrap from a triangle: over the edge or around the
/// corner on which the nearest place of the triangle at hand lies.
WrapFoot nearest_foot(const SurfaceNeighbours& surface, const PointColumnsF& wrap, const Eigen::Vector3f& point,
                      int start)
{
    constexpr int most_steps = 16;
    const auto closest_on = [&](int t) {
        const auto triangle = surface.triangles.row(t);
        ClosestPoint closest = closest_point_on_triangle(point.cast<double>(), corner(wrap, triangle[0]).cast<double>(),
                                                         corner(wrap, triangle[1]).cast<double>(),
                                                         corner(wrap, triangle[2]).cast<double>());
        closest.triangle_idx = t;
        return closest;
    };
    ClosestPoint best = closest_on(start);
    for (int step = 0; step < most_steps; ++step) {
        const ClosestPoint here = best;
        const auto look_at = [&](int t) {
            if (t < 0 || t == here.triangle_idx) return;
            const ClosestPoint other = closest_on(t);
            if (other.distance < best.distance) best = other;
        };
        int away = 0, heaviest = 0;
        for (int c = 0; c < 3; ++c) {
            away += here.barycentric[c] < on_edge;
            if (here.barycentric[c] > here.barycentric[heaviest]) heaviest = c;
        }
        if (away == 0) break;
        for (int c = 0; away == 1 && c < 3; ++c)
            if (here.barycentric[c] < on_edge) look_at(surface.beside[here.triangle_idx][std::size_t(c)]);
        if (away == 2)
            for (const int t : surface.triangles_of[surface.triangles(here.triangle_idx, heaviest)]) look_at(t);
        if (best.triangle_idx == here.triangle_idx) break;
    }
    const auto corners = surface.triangles.row(best.triangle_idx);
    Eigen::Vector3f normal = area_normal(surface, wrap, best.triangle_idx);
    if (best.barycentric.minCoeff() < on_edge) {
        // On an edge or at a corner: the mean of what meets there.
        normal.setZero();
        for (int c = 0; c < 3; ++c) {
            if (best.barycentric[c] < on_edge) continue;
            for (const int t : surface.triangles_of[corners[c]])
                normal += float(best.barycentric[c]) * area_normal(surface, wrap, t).normalized();
        }
    }
    const Eigen::Vector3f line = point - best.point.cast<float>();
    const bool outside = line.dot(normal) > 0.0F;
    constexpr double touching = 1e-6;  // m
    const float distance = float(best.distance);
    WrapFoot foot{best.triangle_idx, outside ? distance : -distance, normal, best.barycentric.cast<float>()};
    if (best.distance > touching) foot.outwards = outside ? line : Eigen::Vector3f(-line);
    foot.outwards /= std::max(foot.outwards.norm(), 1e-20F);
    return foot;
}

/// Points that are on their way over the wrap.
struct Walkers {
    static constexpr int most = 256;
    int count = 0;
    std::array<std::array<float, most>, 3> at;
    std::array<int, most> point, triangle, previous;  ///< which of the points; where it is and came from; -1: nowhere
    std::array<float, most> previous_height;
    // What they see under them.
    std::array<float, most> height, least;  ///< barycentric coordinate times area
    std::array<float, most> corner;         ///< where it is least: 0, 1 or 2
};

void look_under(const SurfaceNeighbours& surface, const PointColumnsF& wrap, Walkers& walkers)
{
    constexpr int lanes = int(LanesF::size());
    const int* const triangles = surface.triangles.data();
    for (int k = walkers.count; k % lanes != 0; ++k) {  // lanes left over look at something
        walkers.triangle[k] = 0;
        for (auto& axis : walkers.at) axis[k] = 0.0F;
    }
    for (int k = 0; k < walkers.count; k += lanes) {
        const auto corner_lanes = [&](int c) {
            return vertex_lanes(wrap, [&](std::size_t i) { return triangles[3 * walkers.triangle[k + i] + c]; });
        };
        const SeenTriangle<LanesF> seen(
            corner_lanes(0), corner_lanes(1), corner_lanes(2),
            {load_lanes(&walkers.at[0][k]), load_lanes(&walkers.at[1][k]), load_lanes(&walkers.at[2][k])});
        const LanesF least = seen.least();
        LanesF corner = 2.0F;
        where(seen.second <= seen.third, corner) = 1.0F;
        where(seen.first <= least, corner) = 0.0F;
        store_lanes(corner, &walkers.corner[k]);
        store_lanes(least, &walkers.least[k]);
        store_lanes(seen.height, &walkers.height[k]);
    }
}

void arrive_at_nearest(const SurfaceNeighbours& surface, const PointColumnsF& wrap, int triangle, int point,
                       FollowedPoints& points)
{
    const Eigen::Vector3f at(points.axes[0][point], points.axes[1][point], points.axes[2][point]);
    const WrapFoot foot = nearest_foot(surface, wrap, at, triangle);
    points.triangles[point] = foot.triangle;
    points.heights[point] = foot.height;
    points.feet[point] = foot;
}

/// Lets those arrive that are over their triangles, and brings the others to the next.
void go_on(const SurfaceNeighbours& surface, const PointColumnsF& wrap, Walkers& walkers, FollowedPoints& points)
{
    constexpr float deep = 0.020F;  // m: so far below this part of the wrap, a bone may come through another one
    int count = 0;
    for (int k = 0; k < walkers.count; ++k) {
        const int point = walkers.point[k], triangle = walkers.triangle[k], previous = walkers.previous[k];
        const float height = walkers.height[k], allowed = points.allowed[point];
        if (walkers.least[k] >= 0.0F) {
            points.triangles[point] = triangle;
            points.heights[point] = height;
            if (height <= allowed) continue;
            const auto at = [&](int c) -> std::array<float, 3> {
                const int v = surface.triangles(triangle, c);
                return {wrap(0, v), wrap(1, v), wrap(2, v)};
            };
            const SeenTriangle<float> seen(at(0), at(1), at(2), {walkers.at[0][k], walkers.at[1][k], walkers.at[2][k]});
            points.feet[point] = {triangle, height, Eigen::Vector3f(seen.normal.data()) / seen.length,
                                  Eigen::Vector3f(seen.first, seen.second, seen.third) / std::max(seen.area, 1e-30F)};
            continue;
        }
        const int next = surface.beside[triangle][std::size_t(int(walkers.corner[k]))];
        const float higher = std::max(height, walkers.previous_height[k]);
        if (next == previous && higher <= allowed && higher > -deep) {  // under an edge, at least as deep
            points.triangles[point] = triangle;
            points.heights[point] = higher;
        } else if (next < 0 || next == previous) {
            arrive_at_nearest(surface, wrap, triangle, point, points);
        } else {
            for (auto& axis : walkers.at) axis[count] = axis[k];
            walkers.point[count] = point;
            walkers.triangle[count] = next;
            walkers.previous[count] = triangle;
            walkers.previous_height[count] = height;
            ++count;
        }
    }
    walkers.count = count;
}

}  // namespace

SurfaceNeighbours::SurfaceNeighbours(const Eigen::Ref<const Triangles>& triangles_in, int num_vertices)
    : triangles(triangles_in), beside(std::size_t(triangles_in.rows()), {-1, -1, -1}), triangles_of(num_vertices)
{
    for (int t = 0; t < int(triangles.rows()); ++t)
        for (int k = 0; k < 3; ++k) triangles_of[triangles(t, k)].push_back(t);
    for (const MeshEdge& edge : mesh_edges(triangles, num_vertices)) {
        const auto opposite = [&](int t) {
            int corner = 0;
            while (triangles(t, corner) == edge.v0 || triangles(t, corner) == edge.v1) ++corner;
            return std::size_t(corner);
        };
        if (edge.right_triangle < 0) continue;
        beside[edge.left_triangle][opposite(edge.left_triangle)] = edge.right_triangle;
        beside[edge.right_triangle][opposite(edge.right_triangle)] = edge.left_triangle;
    }
}

void FollowedPoints::resize(int count)
{
    size_ = count;
    if (count <= int(allowed.size())) return;
    for (std::vector<float>& axis : axes) axis.resize(count);
    allowed.resize(count);
    triangles.resize(count);
    heights.resize(count);
    feet.resize(count);
}

void FollowedPoints::copy(int from, int to)
{
    for (std::vector<float>& axis : axes) axis[to] = axis[from];
    allowed[to] = allowed[from];
    triangles[to] = triangles[from];
    heights[to] = heights[from];
    if (heights[from] > allowed[from]) feet[to] = feet[from];
}

void follow(const SurfaceNeighbours& surface, const PointColumnsF& wrap, const std::vector<char>& moved, int begin,
            int end, FollowedPoints& points)
{
    constexpr int most_steps = 16;
    for (int first = begin; first < end; first += Walkers::most) {
        Walkers walkers;
        for (int i = first; i < std::min(end, first + Walkers::most); ++i) {
            const int t = points.triangles[i];
            const int* const corners = surface.triangles.data() + 3 * std::ptrdiff_t(t);
            walkers.point[walkers.count] = i;
            walkers.triangle[walkers.count] = t;
            walkers.previous[walkers.count] = -1;
            walkers.previous_height[walkers.count] = 0.0F;
            for (std::size_t axis = 0; axis < 3; ++axis) walkers.at[axis][walkers.count] = points.axes[axis][i];
            walkers.count += (moved[corners[0]] | moved[corners[1]] | moved[corners[2]]) != 0;
        }
        for (int step = 0; step < most_steps && walkers.count > 0; ++step) {
            look_under(surface, wrap, walkers);
            go_on(surface, wrap, walkers, points);
        }
        for (int k = 0; k < walkers.count; ++k)
            arrive_at_nearest(surface, wrap, walkers.triangle[k], walkers.point[k], points);
    }
}

}  // namespace ndg
