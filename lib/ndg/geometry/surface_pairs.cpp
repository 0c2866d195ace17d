// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/surface_pairs.h"

#include "ndg/geometry/box_pairs.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"

#include <Eigen/LU>

#include <algorithm>
#include <utility>

namespace ndg {

namespace {

/// Shares along two segments of their nearest points (Ericson 2005, 5.1.9).
std::pair<double, double> nearest_on_edges(const PairCorners& x)
{
    const Eigen::RowVector3d u = x.row(1) - x.row(0), v = x.row(3) - x.row(2), w = x.row(0) - x.row(2);
    const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v), uw = u.dot(w), vw = v.dot(w);
    // Of parallel edges any pair of nearest points will do.
    constexpr double parallel_share = 1e-14;
    const double determinant = uu * vv - uv * uv;
    double s = determinant > parallel_share * uu * vv ? std::clamp((uv * vw - uw * vv) / determinant, 0.0, 1.0) : 0.0;
    double t = vv > 0 ? (uv * s + vw) / vv : 0.0;
    if (t < 0 || t > 1) {
        t = std::clamp(t, 0.0, 1.0);
        s = uu > 0 ? std::clamp((t * uv - uw) / uu, 0.0, 1.0) : 0.0;
    }
    return {s, t};
}

bool inside(double share)
{
    return share > 0 && share < 1;
}

/// Boxes of parts, each as much larger as its own radius, the largest of its corners', and `margin`.
template <class Corners>
Boxes reaching_boxes(const Eigen::Ref<const Points>& vertices, const Corners& corners,
                     const Eigen::Ref<const Eigen::VectorXd>& radii, double margin)
{
    Boxes boxes = bounding_boxes(vertices, corners, margin);
    for (Eigen::Index i = 0; i < corners.rows(); ++i) {
        double radius = 0;
        for (Eigen::Index a = 0; a < corners.cols(); ++a) radius = std::max(radius, radii[corners(i, a)]);
        boxes.row(i).template head<3>().array() -= radius;
        boxes.row(i).template tail<3>().array() += radius;
    }
    return boxes;
}

class PairFinder {
public:
    PairFinder(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Eigen::VectorXd>& radii, double reach)
        : vertices_(vertices), radii_(radii), reach_(reach)
    {
    }

    template <class Corners>
    void add_points(const Corners& points, const Triangles& triangles)
    {
        for (const auto& [p, t] : overlapping_boxes(reaching_boxes(vertices_, points, radii_, reach_),
                                                    reaching_boxes(vertices_, triangles, radii_, 0))) {
            const int point = points(p, 0);
            if ((triangles.row(t).array() == point).any()) continue;
            add(PairKind::point_triangle, {point, triangles(t, 0), triangles(t, 1), triangles(t, 2)});
        }
    }
    /// Of one surface with itself every pair once.
    template <class Edges>
    void add_edges(const Edges& edges, const Edges& others)
    {
        const bool itself = &edges == &others;
        const Boxes boxes = reaching_boxes(vertices_, edges, radii_, 0.5 * reach_);
        const Boxes other_boxes = itself ? boxes : reaching_boxes(vertices_, others, radii_, 0.5 * reach_);
        for (const auto& [e, f] : overlapping_boxes(boxes, other_boxes)) {
            if (itself && (e >= f || edges(e, 0) == others(f, 0) || edges(e, 0) == others(f, 1) ||
                           edges(e, 1) == others(f, 0) || edges(e, 1) == others(f, 1))) {
                continue;
            }
            add(PairKind::edge_edge, {edges(e, 0), edges(e, 1), others(f, 0), others(f, 1)});
        }
    }
    std::vector<SurfacePair> take() { return std::move(pairs_); }

private:
    void add(PairKind kind, const std::array<int, 4>& corners)
    {
        const int first = kind == PairKind::point_triangle ? 1 : 2;
        double radius = 0, other_radius = 0;
        for (int a = 0; a < 4; ++a) {
            double& largest = a < first ? radius : other_radius;
            largest = std::max(largest, radii_[corners[static_cast<std::size_t>(a)]]);
        }
        const double reach = reach_ + radius + other_radius;
        if (PairDistance(kind, pair_corners(vertices_, corners)).squared() < reach * reach) {
            pairs_.push_back({kind, corners});
        }
    }

    const Eigen::Ref<const Points>& vertices_;
    const Eigen::Ref<const Eigen::VectorXd>& radii_;
    double reach_;
    std::vector<SurfacePair> pairs_;
};

}  // namespace

PairDistance::PairDistance(PairKind kind, const PairCorners& corners) : corners_(corners)
{
    directions_.resize(4, 0);
    const auto add_direction = [&](const Eigen::Vector4d& direction) {
        directions_.conservativeResize(4, directions_.cols() + 1);
        directions_.rightCols<1>() = direction;
    };
    if (kind == PairKind::edge_edge) {
        const auto [s, t] = nearest_on_edges(corners);
        weights_ << 1 - s, s, t - 1, -t;
        if (inside(s)) add_direction({-1, 1, 0, 0});
        if (inside(t)) add_direction({0, 0, 1, -1});
    } else {
        const Eigen::Vector3d at =
            closest_point_on_triangle(corners.row(0), corners.row(1), corners.row(2), corners.row(3)).barycentric;
        weights_ << 1, -at;
        // From the first corner that the nearest point depends on towards the others.
        int first = -1;
        for (int a = 0; a < 3; ++a) {
            if (!(at[a] > 0)) continue;
            if (first >= 0) {
                Eigen::Vector4d direction = Eigen::Vector4d::Zero();
                direction[1 + first] = 1;
                direction[1 + a] = -1;
                add_direction(direction);
            } else {
                first = a;
            }
        }
    }
    gap_ = corners.transpose() * weights_;
}

Eigen::Matrix<double, 12, 1> PairDistance::gradient() const
{
    Eigen::Matrix<double, 12, 1> gradient;
    for (int a = 0; a < 4; ++a) gradient.segment<3>(3 * a) = 2 * weights_[a] * gap_;
    return gradient;
}

Eigen::Matrix<double, 12, 12> PairDistance::hessian() const
{
    Eigen::Matrix<double, 12, 12> hessian;
    for (int a = 0; a < 4; ++a) {
        for (int b = 0; b < 4; ++b) {
            hessian.block<3, 3>(3 * a, 3 * b) = 2 * weights_[a] * weights_[b] * Eigen::Matrix3d::Identity();
        }
    }
    const Eigen::Index num_free = directions_.cols();
    if (num_free == 0) return hessian;
    const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, 2> tangents = corners_.transpose() * directions_;
    Eigen::Matrix<double, 12, Eigen::Dynamic, Eigen::ColMajor, 12, 2> mixed(12, num_free);
    for (int a = 0; a < 4; ++a) {
        mixed.middleRows<3>(3 * a) = 2 * (weights_[a] * tangents + gap_ * directions_.row(a));
    }
    const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 2, 2> free =
        2 * tangents.transpose() * tangents;
    if (num_free == 1) {
        hessian -= mixed * mixed.transpose() / free(0, 0);
    } else {
        hessian -= mixed * Eigen::Matrix2d(free).inverse() * mixed.transpose();
    }
    return hessian;
}

double collision_free_share(PairKind kind, const PairCorners& from, const PairCorners& to, double least_distance)
{
    constexpr double kept_share = 1.0 / 3, near_share = 0.8, caution = 0.9, progress = 0.01;
    constexpr int max_advances = 100;
    PairCorners move = to - from;
    move.rowwise() -= move.colwise().mean().eval();
    const Eigen::Vector4d lengths = move.rowwise().norm();
    const double fastest = kind == PairKind::point_triangle
                               ? lengths[0] + lengths.tail<3>().maxCoeff()
                               : lengths.head<2>().maxCoeff() + lengths.tail<2>().maxCoeff();
    const double start = std::sqrt(PairDistance(kind, from).squared()),
                 kept = std::max(kept_share * start, std::min(near_share * start, least_distance));
    double share = 0, distance = start;
    for (int advance = 0; advance < max_advances; ++advance) {
        if (distance - kept >= fastest * (1 - share)) return 1;
        const double length = caution * (distance - kept) / fastest;
        if (advance > 0 && distance - kept < progress * start) break;
        share += length;
        distance = std::sqrt(PairDistance(kind, from + share * move).squared());
    }
    return share;
}

PairCorners pair_corners(const Eigen::Ref<const Points>& vertices, const std::array<int, 4>& pair)
{
    PairCorners corners;
    for (int a = 0; a < 4; ++a) corners.row(a) = vertices.row(pair[a]);
    return corners;
}

SurfaceParts::SurfaceParts(const Eigen::Ref<const Triangles>& triangles, int num_vertices) : triangles_(triangles)
{
    std::vector<int> points(triangles.data(), triangles.data() + triangles.size());
    std::sort(points.begin(), points.end());
    points.erase(std::unique(points.begin(), points.end()), points.end());
    points_ = Eigen::Map<const Eigen::VectorXi>(points.data(), static_cast<Eigen::Index>(points.size()));
    const std::vector<MeshEdge> edges = mesh_edges(triangles, num_vertices);
    edges_.resize(static_cast<Eigen::Index>(edges.size()), 2);
    for (int e = 0; e < int(edges.size()); ++e) edges_.row(e) << edges[e].v0, edges[e].v1;
}

std::vector<SurfacePair> SurfaceParts::close_pairs(const Eigen::Ref<const Points>& vertices, double reach) const
{
    return close_pairs(vertices, reach, Eigen::VectorXd::Zero(vertices.rows()));
}

std::vector<SurfacePair> SurfaceParts::close_pairs(const Eigen::Ref<const Points>& vertices, double reach,
                                                   const Eigen::Ref<const Eigen::VectorXd>& radii) const
{
    PairFinder finder(vertices, radii, reach);
    finder.add_points(points_, triangles_);
    finder.add_edges(edges_, edges_);
    return finder.take();
}

std::vector<SurfacePair> SurfaceParts::close_pairs(const SurfaceParts& other, const Eigen::Ref<const Points>& vertices,
                                                   double reach, const Eigen::Ref<const Eigen::VectorXd>& radii) const
{
    PairFinder finder(vertices, radii, reach);
    finder.add_points(points_, other.triangles_);
    finder.add_points(other.points_, triangles_);
    finder.add_edges(edges_, other.edges_);
    return finder.take();
}

}  // namespace ndg
