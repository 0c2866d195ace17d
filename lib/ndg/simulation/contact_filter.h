// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/geometry/surface_pairs.h"

#include <vector>

namespace ndg {

/// A StepFilter (newton.h): straight ways that keep every vertex within a radius of its place at the start of a round,
/// and all pairs apart. Pairs found within those radii are then all that can meet in the round.
class ContactFilter {
public:
    /// Keeps references to all three. `radii`: of every vertex, m, infinite for one that no pair can have. Pairs keep
    /// `least_distance`, m, or come no nearer than they are.
    ContactFilter(const Points& start, const Eigen::VectorXd& radii, const std::vector<SurfacePair>& pairs,
                  double least_distance);
    /// Keeps pairs that are no elements of the energy as far apart as they would push each other, m. `is_element`: of
    /// every pair; a reference is kept.
    void keep_out(const std::vector<char>& is_element, double contact_distance);

    /// False where the radii shorten the step so much, or a pair that is no element is so near, that a new round is
    /// better.
    bool operator()(const Points& from, Points& to, bool by_vertex) const;

private:
    double share_in_ball(int vertex, const Eigen::RowVector3d& offset, const Eigen::RowVector3d& move) const;

    const Points& start_;
    const Eigen::VectorXd& radii_;
    const std::vector<SurfacePair>& pairs_;
    double least_distance_, contact_distance_ = 0;
    const std::vector<char>* is_element_ = nullptr;
    Eigen::VectorXd squared_radii_;
    std::vector<int> begin_, pairs_at_;  ///< of vertex v: pairs_at_[begin_[v]] to pairs_at_[begin_[v + 1]]
};

/// The pairs less than `reach` apart.
std::vector<SurfacePair> near_pairs(const std::vector<SurfacePair>& pairs, const Points& vertices, double reach);

/// Takes out the pairs of which every two corners belong to two triangles that cross: what cannot be kept apart any
/// more. `crossings`: pairs of triangles, as of crossing_triangles().
void remove_crossed(std::vector<SurfacePair>& pairs, const Triangles& triangles,
                    const std::vector<std::pair<int, int>>& crossings);

}  // namespace ndg
