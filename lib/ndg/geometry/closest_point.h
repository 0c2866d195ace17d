// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"

#include <array>
#include <memory>
#include <vector>

namespace ndg {

struct ClosestPoint {
    int triangle_idx = -1;
    Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();  ///< of the triangle's three vertices
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    double distance = 0.0;  ///< in metres (not squared)
};

/// Closest point on a triangle, with barycentric coordinates.
ClosestPoint closest_point_on_triangle(const Eigen::Vector3d& point, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                       const Eigen::Vector3d& c);

struct ClosestOnSegments {
    std::array<int, 2> segment{};  ///< its two vertices
    double share = 0.0;            ///< of the second
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
};

/// Closest point on any of the segments between two vertices each, of which there must be at least one.
ClosestOnSegments closest_on_segments(const Eigen::Ref<const Points>& vertices,
                                      const std::vector<std::array<int, 2>>& segments, const Eigen::Vector3d& point);

/// Bounding-volume hierarchy over a triangle mesh for closest-point and ray-free inside queries.
class TriangleTree {
public:
    TriangleTree(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles);
    ~TriangleTree();
    TriangleTree(TriangleTree&&) noexcept;

    ClosestPoint closest(const Eigen::Vector3d& point) const;
    /// Signed distance to a closed, outward, manifold mesh, negative inside: the sign of the angle-weighted
    /// pseudonormal at the closest point (Baerentzen and Aanaes 2005). `nearest` receives that point.
    double signed_distance(const Eigen::Vector3d& point, ClosestPoint* nearest = nullptr) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Generalised winding number of a closed, outward mesh at each point: 1 inside, 0 outside. Direct sum of solid angles
/// (Van Oosterom and Strackee 1983; Jacobson et al. 2013).
Eigen::VectorXd winding_numbers(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                                const Eigen::Ref<const Points>& query_points);

}  // namespace ndg
