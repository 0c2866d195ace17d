// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/closest_point.h"

#include "ndg/core/error.h"
#include "ndg/geometry/winding_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace ndg {
namespace {

constexpr int leaf_size = 4;
/// Depth of a median-split tree over 2^31 triangles, with room to spare.
constexpr int max_stack = 64;

struct Corners {
    Corners() = default;
    Corners(const Eigen::Vector3d& a_, const Eigen::Vector3d& b_, const Eigen::Vector3d& c_) : a(a_), b(b_), c(c_)
    {
        const double largest_edge = std::max((b - a).squaredNorm(), (c - a).squaredNorm());
        flat = (b - a).cross(c - a).norm() <= 1e-12 * largest_edge;
    }

    Eigen::Vector3d a, b, c;
    bool flat = true;  ///< a needle has no usable plane; its edges hold all its points
};

/// Parameter in [0, 1] of the point nearest to `point` on the segment from `a` to `b`.
double segment_parameter(const Eigen::Vector3d& point, const Eigen::Vector3d& a, const Eigen::Vector3d& b)
{
    const double squared_length = (b - a).squaredNorm();
    return squared_length > 0.0 ? std::clamp((point - a).dot(b - a) / squared_length, 0.0, 1.0) : 0.0;
}

/// Barycentric coordinates of the nearest point on the three edges.
Eigen::Vector3d nearest_on_edges(const Eigen::Vector3d& point, const Corners& corners)
{
    const std::array<const Eigen::Vector3d*, 3> vertex{&corners.a, &corners.b, &corners.c};
    Eigen::Vector3d best = Eigen::Vector3d::Zero();
    double best_squared = std::numeric_limits<double>::infinity();
    for (int from = 0; from < 3; ++from) {
        const int to = (from + 1) % 3;
        const auto& start = *vertex[from];
        const auto& end = *vertex[to];
        const double t = segment_parameter(point, start, end);
        const double squared = (start + t * (end - start) - point).squaredNorm();
        if (squared < best_squared) {
            best_squared = squared;
            best.setZero();
            best[from] = 1.0 - t;
            best[to] = t;
        }
    }
    return best;
}

/// Barycentric coordinates of the nearest point, by the Voronoi regions of the triangle (Ericson, Real-Time Collision
/// Detection, 5.1.5).
Eigen::Vector3d nearest_barycentric(const Eigen::Vector3d& point, const Corners& corners)
{
    if (corners.flat) return nearest_on_edges(point, corners);
    const Eigen::Vector3d ab = corners.b - corners.a;
    const Eigen::Vector3d ac = corners.c - corners.a;
    const Eigen::Vector3d ap = point - corners.a;
    const double d1 = ab.dot(ap);
    const double d2 = ac.dot(ap);
    if (d1 <= 0.0 && d2 <= 0.0) return {1, 0, 0};
    const Eigen::Vector3d bp = point - corners.b;
    const double d3 = ab.dot(bp);
    const double d4 = ac.dot(bp);
    if (d3 >= 0.0 && d4 <= d3) return {0, 1, 0};
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
        const double t = d1 / (d1 - d3);
        return {1 - t, t, 0};
    }
    const Eigen::Vector3d cp = point - corners.c;
    const double d5 = ab.dot(cp);
    const double d6 = ac.dot(cp);
    if (d6 >= 0.0 && d5 <= d6) return {0, 0, 1};
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
        const double t = d2 / (d2 - d6);
        return {1 - t, 0, t};
    }
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
        const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return {0, 1 - t, t};
    }
    const double scale = 1.0 / (va + vb + vc);
    return {1.0 - (vb + vc) * scale, vb * scale, vc * scale};
}

Eigen::Vector3d at_barycentric(const Corners& corners, const Eigen::Vector3d& barycentric)
{
    return barycentric[0] * corners.a + barycentric[1] * corners.b + barycentric[2] * corners.c;
}

}  // namespace

ClosestPoint closest_point_on_triangle(const Eigen::Vector3d& point, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                       const Eigen::Vector3d& c)
{
    const Corners corners{a, b, c};
    ClosestPoint result;
    result.triangle_idx = 0;
    result.barycentric = nearest_barycentric(point, corners);
    result.point = at_barycentric(corners, result.barycentric);
    result.distance = (result.point - point).norm();
    return result;
}

ClosestOnSegments closest_on_segments(const Eigen::Ref<const Points>& vertices,
                                      const std::vector<std::array<int, 2>>& segments, const Eigen::Vector3d& point)
{
    require(!segments.empty(), "there is no segment to find the closest point on");
    double best = std::numeric_limits<double>::infinity();
    ClosestOnSegments result;
    for (const auto& segment : segments) {
        const Eigen::Vector3d a = vertices.row(segment[0]), b = vertices.row(segment[1]);
        const double length = (b - a).squaredNorm();
        const double share = length > 0.0 ? std::clamp((point - a).dot(b - a) / length, 0.0, 1.0) : 0.0;
        const Eigen::Vector3d candidate = (1.0 - share) * a + share * b;
        const double distance = (candidate - point).squaredNorm();
        if (distance >= best) continue;
        best = distance;
        result = {segment, share, candidate};
    }
    return result;
}

struct TriangleTree::State {
    /// Children of an inner node: the next node and `right`. A leaf holds triangles first .. first + count - 1.
    struct Node {
        Eigen::Vector3d low, high;
        int right = -1;
        int first = 0, count = 0;

        double squared_distance(const Eigen::Vector3d& point) const
        {
            return (low - point).cwiseMax(point - high).cwiseMax(0.0).squaredNorm();
        }
    };

    std::vector<Node> nodes;
    std::vector<Corners> corners;  ///< in leaf order
    std::vector<int> triangle_of_leaf_slot;
    Triangles triangles;
    Points face_normals;    ///< unit
    Points vertex_normals;  ///< angle-weighted, not normalised
    Points edge_normals;    ///< row 3 t + k: sum over the triangles of edge (k, k + 1) of triangle t

    int build(std::vector<int>& order, int first, int count, const std::vector<Corners>& all)
    {
        const int node_idx = static_cast<int>(nodes.size());
        nodes.emplace_back();
        Eigen::AlignedBox3d box;
        Eigen::AlignedBox3d centres;
        for (int slot = first; slot < first + count; ++slot) {
            const Corners& t = all[order[slot]];
            box.extend(t.a).extend(t.b).extend(t.c);
            centres.extend(t.a + t.b + t.c);
        }
        Node node;
        node.low = box.min();
        node.high = box.max();
        if (count <= leaf_size) {
            node.first = first;
            node.count = count;
            nodes[node_idx] = node;
            return node_idx;
        }
        Eigen::Index axis = 0;
        centres.sizes().maxCoeff(&axis);
        const auto centre = [&](int triangle) {
            const Corners& t = all[triangle];
            return t.a[axis] + t.b[axis] + t.c[axis];
        };
        const int half = count / 2;
        std::nth_element(order.begin() + first, order.begin() + first + half, order.begin() + first + count,
                         [&](int left, int right) {
                             const double x = centre(left);
                             const double y = centre(right);
                             return x < y || (x == y && left < right);
                         });
        build(order, first, half, all);
        node.right = build(order, first + half, count - half, all);
        nodes[node_idx] = node;
        return node_idx;
    }
    void make_pseudonormals(const Eigen::Ref<const Points>& vertices);
};

TriangleTree::TriangleTree(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles)
    : state_(std::make_unique<State>())
{
    require(triangles.rows() > 0, "a triangle tree needs at least one triangle");
    require(vertices.allFinite(), "a triangle tree needs finite vertices");
    require(triangles.minCoeff() >= 0 && triangles.maxCoeff() < vertices.rows(),
            "a triangle names a vertex outside 0..{}", vertices.rows() - 1);
    const auto count = static_cast<std::size_t>(triangles.rows());
    std::vector<Corners> all(count);
    for (std::size_t t = 0; t < count; ++t) {
        const auto row = triangles.row(static_cast<Eigen::Index>(t));
        all[t] = {vertices.row(row[0]), vertices.row(row[1]), vertices.row(row[2])};
    }
    State& state = *state_;
    state.triangle_of_leaf_slot.resize(count);
    std::iota(state.triangle_of_leaf_slot.begin(), state.triangle_of_leaf_slot.end(), 0);
    state.nodes.reserve(count);
    state.build(state.triangle_of_leaf_slot, 0, static_cast<int>(count), all);
    state.corners.reserve(count);
    for (const int triangle : state.triangle_of_leaf_slot) {
        state.corners.push_back(all[triangle]);
    }
    state.triangles = triangles;
    state.make_pseudonormals(vertices);
}

/// Normals of faces, edges and vertices; a flat triangle has none and adds nothing.
void TriangleTree::State::make_pseudonormals(const Eigen::Ref<const Points>& vertices)
{
    const Eigen::Index count = triangles.rows();
    face_normals = Points::Zero(count, 3);
    vertex_normals = Points::Zero(vertices.rows(), 3);
    edge_normals = Points::Zero(3 * count, 3);
    std::vector<std::array<int, 3>> edges;  // smaller vertex, larger vertex, 3 t + k
    edges.reserve(static_cast<std::size_t>(3 * count));
    for (Eigen::Index t = 0; t < count; ++t) {
        std::array<Eigen::Vector3d, 3> corner;
        for (int k = 0; k < 3; ++k) corner[k] = vertices.row(triangles(t, k)).transpose();
        const Eigen::Vector3d cross = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
        if (cross.norm() > 0.0) face_normals.row(t) = cross.normalized().transpose();
        for (int k = 0; k < 3; ++k) {
            const Eigen::Vector3d& at = corner[k];
            const Eigen::Vector3d to_next = corner[(k + 1) % 3] - at;
            const Eigen::Vector3d to_last = corner[(k + 2) % 3] - at;
            const double angle = std::atan2(to_next.cross(to_last).norm(), to_next.dot(to_last));
            vertex_normals.row(triangles(t, k)) += angle * face_normals.row(t);
            const auto [low, high] = std::minmax(triangles(t, k), triangles(t, (k + 1) % 3));
            edges.push_back({low, high, static_cast<int>(3 * t) + k});
        }
    }
    std::sort(edges.begin(), edges.end());
    for (std::size_t first = 0; first < edges.size();) {
        std::size_t end = first;
        Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
        for (; end < edges.size() && edges[end][0] == edges[first][0] && edges[end][1] == edges[first][1]; ++end)
            sum += face_normals.row(edges[end][2] / 3);
        for (; first < end; ++first) edge_normals.row(edges[first][2]) = sum;
    }
}

TriangleTree::~TriangleTree() = default;
TriangleTree::TriangleTree(TriangleTree&&) noexcept = default;

ClosestPoint TriangleTree::closest(const Eigen::Vector3d& point) const
{
    require(point.allFinite(), "the closest point of a non-finite point is undefined");
    const State& state = *state_;
    struct Pending {
        int node;
        double squared;
    };
    std::array<Pending, max_stack> stack;
    std::size_t top = 0;
    stack[top++] = {0, state.nodes[0].squared_distance(point)};
    ClosestPoint best;
    double best_squared = std::numeric_limits<double>::infinity();
    while (top > 0) {
        const Pending pending = stack[--top];
        if (pending.squared > best_squared) continue;
        const auto& node = state.nodes[pending.node];
        if (node.right < 0) {
            for (int slot = node.first; slot < node.first + node.count; ++slot) {
                const Corners& corners = state.corners[slot];
                const Eigen::Vector3d barycentric = nearest_barycentric(point, corners);
                const Eigen::Vector3d nearest = at_barycentric(corners, barycentric);
                const double squared = (nearest - point).squaredNorm();
                const int triangle = state.triangle_of_leaf_slot[slot];
                // Among equally near triangles the first wins, whatever the shape of the tree.
                if (squared < best_squared || (squared == best_squared && triangle < best.triangle_idx)) {
                    best_squared = squared;
                    best.triangle_idx = triangle;
                    best.barycentric = barycentric;
                    best.point = nearest;
                }
            }
            continue;
        }
        Pending nearer{pending.node + 1, state.nodes[pending.node + 1].squared_distance(point)};
        Pending farther{node.right, state.nodes[node.right].squared_distance(point)};
        if (farther.squared < nearer.squared) std::swap(nearer, farther);
        if (farther.squared <= best_squared) stack[top++] = farther;
        if (nearer.squared <= best_squared) stack[top++] = nearer;
    }
    best.distance = std::sqrt(best_squared);
    return best;
}

double TriangleTree::signed_distance(const Eigen::Vector3d& point, ClosestPoint* nearest) const
{
    const ClosestPoint found = closest(point);
    if (nearest) *nearest = found;
    // Which feature of the triangle the closest point lies on: as many zero coordinates as it lacks dimensions.
    int zeros = 0, zero = 0, largest = 0;
    for (int k = 0; k < 3; ++k) {
        if (found.barycentric[k] <= 0.0) {
            ++zeros;
            zero = k;
        }
        if (found.barycentric[k] > found.barycentric[largest]) largest = k;
    }
    const State& state = *state_;
    const Eigen::Index t = found.triangle_idx;
    Eigen::RowVector3d normal = state.face_normals.row(t);
    if (zeros == 1) normal = state.edge_normals.row(3 * t + (zero + 1) % 3);
    if (zeros == 2) normal = state.vertex_normals.row(state.triangles(t, largest));
    return normal.dot((point - found.point).transpose()) < 0.0 ? -found.distance : found.distance;
}

Eigen::VectorXd winding_numbers(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                                const Eigen::Ref<const Points>& query_points)
{
    Eigen::VectorXd result(query_points.rows());
#pragma omp parallel
    {
        // Offsets and distances per vertex are shared by its six or so triangles.
        Points offsets(vertices.rows(), 3);
        Eigen::VectorXd lengths(vertices.rows());
#pragma omp for schedule(static)
        for (Eigen::Index query = 0; query < query_points.rows(); ++query) {
            for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
                offsets.row(v) = vertices.row(v) - query_points.row(query);
                lengths[v] = offsets.row(v).norm();
            }
            double half_angles = 0.0;
            for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
                const int i = triangles(t, 0);
                const int j = triangles(t, 1);
                const int k = triangles(t, 2);
                half_angles += half_solid_angle(offsets.row(i), offsets.row(j), offsets.row(k), lengths[i], lengths[j],
                                                lengths[k]);
            }
            result[query] = half_angles / (2.0 * M_PI);
        }
    }
    return result;
}

}  // namespace ndg
