// SPDX-License-Identifier: Apache-2.0
// Deformations as offsets of vertices at rest that linear blend skinning then moves: X = LBS(X_rest + offsets)
// (NDG equation 21, after pose blend shapes: Loper et al. 2015).
#pragma once

#include "ndg/deform/posed_body.h"
#include "ndg/deform/residuals.h"

#include <Eigen/Core>

namespace ndg {

/// What takes any skinned vertices at rest to deformed ones, N x 3, by bounded_inverse().
Points rest_offsets(const Eigen::Ref<const Points>& rest, const SkinningWeights& weights,
                    const std::vector<Eigen::Isometry3d>& world_from_rest, const Eigen::Ref<const Points>& deformed);
/// The blended motions of a vertex's joints, which skinning applies to it.
Eigen::Matrix<double, 3, 4> blended_motion(const SkinningWeights& weights,
                                           const std::vector<Eigen::Isometry3d>& world_from_rest, int vertex);

/// Of the free vertices (muscle wrap, then skin; 2 N_w x 3, m); the bone wrap is that of the posed body.
class RestOffsets {
public:
    explicit RestOffsets(const Template& body_template);

    int num_vertices() const { return 2 * num_wrap_; }
    /// What takes the rest shape to these deformed vertices (N_v x 3, as stored), by bounded_inverse().
    Points offsets(const PosedBody& posed, const Eigen::Ref<const PointsF>& vertices) const;
    /// N_v x 3.
    Points vertices(const PosedBody& posed, const Eigen::Ref<const Points>& offsets) const;

private:
    int num_wrap_;
    SkinningWeights weights_;       ///< of the volume vertices
    SkinningWeights free_weights_;  ///< of the free ones among them
};

/// Smallest stretch of a blend of joint motions that is undone as it is.
constexpr double least_blend_stretch = 0.2;

/// The way back through a blend of joint motions with this linear part: its inverse, where no direction is stretched by
/// less than `least`. Blends of opposed rotations collapse directions, and an inverse would ask for offsets without
/// bound: there a stretch s is undone by s / least^2 instead of 1 / s, which is continuous and at most 1 / least.
Eigen::Matrix3d bounded_inverse(const Eigen::Matrix3d& blend, double least = least_blend_stretch);

}  // namespace ndg
