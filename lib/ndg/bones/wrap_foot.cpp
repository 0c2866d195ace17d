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

WrapFoot find_foot(const SurfaceNeighbours& surface, const PointColumnsF& wrap, const Eigen::Vector3f& point, int start,
                   float allowed)
{
    constexpr int most_steps = 16;
    int t = start, previous = -1;
    float previous_height = 0.0F;
    for (int step = 0; step < most_steps; ++step) {
        const auto corners = surface.triangles.row(t);
        const Eigen::Vector3f a = corner(wrap, corners[0]), u = corner(wrap, corners[1]) - a,
                              v = corner(wrap, corners[2]) - a, normal = u.cross(v), d = point - a;
        const float area = normal.squaredNorm();
        const Eigen::Vector3f across = normal.cross(d);
        // Barycentric coordinates times area: of u and v.
        const float second = across.dot(v), third = -across.dot(u), first = area - second - third;
        const float length = std::sqrt(std::max(area, 1e-30F)), height = d.dot(normal) / length;
        if (std::min({first, second, third}) >= 0.0F)
            return {t, height, normal / length, Eigen::Vector3f(first, second, third) / std::max(area, 1e-30F)};
        const int opposite = first <= second && first <= third ? 0 : (second <= third ? 1 : 2);
        const int next = surface.beside[t][std::size_t(opposite)];
        if (next == previous && std::max(height, previous_height) <= allowed)
            return {t, std::max(height, previous_height), {}, {}};  // under an edge, at least as deep
        if (next < 0 || next == previous) break;
        previous = t;
        previous_height = height;
        t = next;
    }
    return nearest_foot(surface, wrap, point, t);
}

}  // namespace ndg
