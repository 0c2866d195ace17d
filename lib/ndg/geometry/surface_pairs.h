// SPDX-License-Identifier: Apache-2.0
// Vertex against triangle and edge against edge: the pairs of a surface's parts that touch first when it meets itself.
// Their distances with derivatives, which of them are near, and how far they can move without passing through each
// other.
#pragma once

#include "ndg/core/types.h"

#include <array>
#include <vector>

namespace ndg {

enum class PairKind { point_triangle, edge_edge };
/// Four corners, one a row: the point and its triangle, or two ends of each edge.
using PairCorners = Eigen::Matrix<double, 4, 3>;

/// Squared distance of a pair. Both parts' nearest points are linear in the corners, p - q = sum of w_a x_a with
/// weights that minimise it over the inside of the nearest features; derivatives follow from the minimum's (envelope
/// theorem):
///   d = |r|^2, grad_a d = 2 w_a r, and the Hessian that at fixed weights less what moving the weights gives back.
class PairDistance {
public:
    PairDistance(PairKind kind, const PairCorners& corners);

    double squared() const { return gap_.squaredNorm(); }
    /// From the second part's nearest point to the first's.
    const Eigen::Vector3d& gap() const { return gap_; }
    /// w_a of the corners; they sum to zero.
    const Eigen::Vector4d& weights() const { return weights_; }
    /// By the corners' coordinates, stacked. Continuous wherever the two edges of a pair are not parallel.
    Eigen::Matrix<double, 12, 1> gradient() const;
    Eigen::Matrix<double, 12, 12> hessian() const;

private:
    PairCorners corners_;
    Eigen::Vector4d weights_;
    /// How weights change with the free coordinates of the nearest points on their features, one a column.
    Eigen::Matrix<double, 4, Eigen::Dynamic, Eigen::ColMajor, 4, 2> directions_;
    Eigen::Vector3d gap_;
};

/// Largest share of straight ways, corner by corner, on which the two parts come no nearer than `least_distance`, nor
/// than a third of their distance before, to a few percent of that; parts that are nearer already do not come nearer.
/// By conservative advancement (additive CCD, Li et al. 2021): no step is longer than the distance left over the
/// fastest approach. 0 for parts that touch.
double collision_free_share(PairKind kind, const PairCorners& from, const PairCorners& to, double least_distance);

struct SurfacePair {
    PairKind kind;
    std::array<int, 4> vertices;
};
PairCorners pair_corners(const Eigen::Ref<const Points>& vertices, const std::array<int, 4>& pair);

/// The parts of a surface that can meet.
class SurfaceParts {
public:
    /// `num_vertices`: of all that positions have.
    SurfaceParts(const Eigen::Ref<const Triangles>& triangles, int num_vertices);

    /// Pairs without a common vertex that are less than `reach` apart, points against triangles first, ascending.
    std::vector<SurfacePair> close_pairs(const Eigen::Ref<const Points>& vertices, double reach) const;
    /// The same where every vertex may be as far off as `radii` has it, N_v: a pair's reach is longer by the largest of
    /// either part's. Radii must be finite.
    std::vector<SurfacePair> close_pairs(const Eigen::Ref<const Points>& vertices, double reach,
                                         const Eigen::Ref<const Eigen::VectorXd>& radii) const;
    /// Pairs of a part of this surface and one of another among the same vertices, which has none in common with it:
    /// points of this one first, then those of the other, then edges.
    std::vector<SurfacePair> close_pairs(const SurfaceParts& other, const Eigen::Ref<const Points>& vertices,
                                         double reach, const Eigen::Ref<const Eigen::VectorXd>& radii) const;

    /// All that belong to the surface, ascending.
    const Eigen::Matrix<int, Eigen::Dynamic, 1>& points() const { return points_; }
    const Triangles& triangles() const { return triangles_; }

private:
    Triangles triangles_;
    Eigen::Matrix<int, Eigen::Dynamic, 1> points_;
    Eigen::Matrix<int, Eigen::Dynamic, 2, Eigen::RowMajor> edges_;
};

}  // namespace ndg
