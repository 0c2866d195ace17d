// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/section_hull.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <utility>

namespace ndg {

namespace {

using Polygon = std::vector<Eigen::Vector2d>;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b)
{
    return a[0] * b[1] - a[1] * b[0];
}

/// Counter-clockwise (Andrew's monotone chain).
Polygon convex_hull(Polygon points)
{
    std::sort(points.begin(), points.end(), [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
        return a[0] < b[0] || (a[0] == b[0] && a[1] < b[1]);
    });
    if (points.size() < 3) return points;
    Polygon hull;
    const auto add_chain = [&](auto begin, auto end, std::size_t keep) {
        for (auto it = begin; it != end; ++it) {
            while (hull.size() > keep && cross(hull.back() - hull[hull.size() - 2], *it - hull.back()) <= 0.0)
                hull.pop_back();
            hull.push_back(*it);
        }
    };
    add_chain(points.begin(), points.end(), 1);
    const std::size_t lower = hull.size();
    add_chain(points.rbegin() + 1, points.rend(), lower);
    hull.pop_back();
    return hull;
}

/// Least distance of the origin inside the edges of a counter-clockwise convex polygon; negative outside.
double origin_depth(const Polygon& hull)
{
    double depth = std::numeric_limits<double>::max();
    for (std::size_t i = 0; i < hull.size(); ++i) {
        const Eigen::Vector2d edge = hull[(i + 1) % hull.size()] - hull[i];
        if (edge.norm() > 0.0) depth = std::min(depth, cross(edge, -hull[i]) / edge.norm());
    }
    return depth;
}

/// Closed chains of the section, as points in the plane around `centre`.
std::vector<Polygon> section_chains(const Eigen::Ref<const Points>& vertices,
                                    const Eigen::Ref<const Triangles>& triangles, const SectionHull& frame)
{
    const Eigen::Vector3d &n = frame.normal, &centre = frame.centre;
    // A vertex in the plane counts as above it, so that every section is made of edges cut in two.
    const Eigen::VectorXd height = (vertices.rowwise() - centre.transpose()) * n;
    struct Node {
        Eigen::Vector2d place;
        std::array<int, 2> next{-1, -1};
    };
    std::vector<Node> nodes;
    std::unordered_map<std::int64_t, int> node_of_edge;
    const auto node = [&](int a, int b) {
        if (a > b) std::swap(a, b);
        const auto [found, fresh] = node_of_edge.try_emplace(static_cast<std::int64_t>(a) * vertices.rows() + b,
                                                             static_cast<int>(nodes.size()));
        if (fresh) {
            const double t = height[a] / (height[a] - height[b]);
            const Eigen::Vector3d point =
                (vertices.row(a) + t * (vertices.row(b) - vertices.row(a))).transpose() - centre;
            nodes.push_back({{point.dot(frame.u), point.dot(frame.w)}, {-1, -1}});
        }
        return found->second;
    };
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        std::array<int, 2> cut{-1, -1};
        int count = 0;
        for (int k = 0; k < 3; ++k) {
            const int a = triangles(t, k), b = triangles(t, (k + 1) % 3);
            if ((height[a] >= 0.0) != (height[b] >= 0.0)) cut[count++] = node(a, b);
        }
        if (count != 2) continue;
        for (std::size_t i = 0; i < 2; ++i) {
            Node& from = nodes[cut[i]];
            from.next[from.next[0] < 0 ? 0 : 1] = cut[1 - i];
        }
    }
    std::vector<char> seen(nodes.size(), 0);
    std::vector<Polygon> chains;
    for (std::size_t start = 0; start < nodes.size(); ++start) {
        if (seen[start]) continue;
        Polygon chain;
        int at = static_cast<int>(start);
        while (at >= 0 && !seen[at]) {
            Node& current = nodes[at];
            seen[at] = 1;
            chain.push_back(current.place);
            at = -1;
            for (const int next : current.next)
                if (next >= 0 && !seen[next]) at = next;
        }
        chains.push_back(std::move(chain));
    }
    return chains;
}

}  // namespace

double SectionHull::girth() const
{
    double length = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) length += (points[(i + 1) % points.size()] - points[i]).norm();
    return length;
}

SectionHull section_hull(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                         const Eigen::Vector3d& centre, const Eigen::Vector3d& normal)
{
    const Eigen::Vector3d n = normal.normalized(), u = n.unitOrthogonal();
    SectionHull result{centre, n, u, n.cross(u), {}};
    double best_depth = -std::numeric_limits<double>::max();
    for (Polygon& chain : section_chains(vertices, triangles, result)) {
        if (chain.size() < 3) continue;
        Polygon hull = convex_hull(std::move(chain));
        const double depth = origin_depth(hull);
        if (depth <= best_depth) continue;
        best_depth = depth;
        result.points = std::move(hull);
    }
    return result;
}

}  // namespace ndg
