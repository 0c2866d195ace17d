// SPDX-License-Identifier: Apache-2.0
// Points of a skin projected to the bones of a skeleton (segments from joint to joint), and projections that slide
// along it until neighbours on the skin have neighbouring projections (Romero et al. 2020, 3.2).
#pragma once

#include "ndg/body/skeleton.h"
#include "ndg/core/types.h"

#include <vector>

namespace ndg {

/// A place on a skeleton: on the bone that ends at `joint`, `along` metres from the joint's parent.
struct SkeletonPoint {
    int joint = 1;
    double along = 0;
};

/// A skeleton at rest as a metric tree: distances are those along its bones.
class SkeletonTree {
public:
    /// `joint_positions`: K x 3. `flesh_joints`: K, which joints move flesh, each the bones that begin at it; the
    /// others are no nearest place, but ways lead over them. Empty: all. Throws InputError where no bone is left.
    SkeletonTree(const Skeleton& skeleton, const Eigen::Ref<const Points>& joint_positions,
                 const std::vector<bool>& flesh_joints = {});

    Eigen::Vector3d position(const SkeletonPoint& point) const;
    /// The nearest place on a bone that moves flesh; of equally near ones the first.
    SkeletonPoint nearest(const Eigen::Vector3d& position) const;
    /// Along the bones, m.
    double distance(const SkeletonPoint& a, const SkeletonPoint& b) const;
    /// The place that minimises sum weight_i distance(place, point_i)^2: there is one, as a tree branches but never
    /// closes. Looked for from `start` on.
    SkeletonPoint mean(const std::vector<SkeletonPoint>& points, const std::vector<double>& weights,
                       const SkeletonPoint& start) const;

private:
    /// Where `point` lies as seen along the bone of `joint`: on it 0 to its length, before and beyond it the way there.
    double coordinate(int joint, const SkeletonPoint& point) const;

    std::vector<int> parents_;
    std::vector<int> candidates_;  ///< bones (by their end) that can be the nearest
    Points positions_;
    std::vector<double> lengths_;             ///< of the bone that ends at each joint
    std::vector<std::vector<int>> bones_at_;  ///< the bones (by their end) that meet at each joint
    RowMatrix distances_;                     ///< K x K, along the bones
};

struct ProjectionOptions {
    /// Distance on the skin over which projections are evened out, m; 0: each at its nearest bone.
    double smoothing_length = 0.1;
};

/// Projections of the vertices of a surface. Each starts at its nearest bone; then they minimise
///   sum over edges d(p_a, p_b)^2 / 2 + sum_a n_a (l_a / smoothing_length)^2 d(p_a, nearest_a)^2 / 2
/// with distances along the bones, n_a neighbours of mean distance l_a, by sweeps until none moves by more than 0.01 mm
/// (or 2 000). The second term keeps all from running together, which plain Laplacian smoothing converges to.
std::vector<SkeletonPoint> project_to_skeleton(const SkeletonTree& tree, const Eigen::Ref<const Points>& vertices,
                                               const Eigen::Ref<const Triangles>& triangles,
                                               const ProjectionOptions& options);

}  // namespace ndg
