// SPDX-License-Identifier: Apache-2.0
// Fits that bones are placed with: similarities, frames along a bone.
#pragma once

#include "ndg/core/types.h"

namespace ndg {

/// x -> linear * x + translation that takes `from` to `to` (N x 3 each) with least squared error, linear a rotation
/// times a scale (Umeyama 1991). Throws Error for fewer than three points.
Eigen::Affine3d fit_similarity(const Eigen::Ref<const Points>& from, const Eigen::Ref<const Points>& to);

/// Right-handed orthonormal frame, first column along `axis`, second column in the plane of axis and `reference`.
/// Throws Error when the two are parallel or zero.
Eigen::Matrix3d frame_along(const Eigen::Vector3d& axis, const Eigen::Vector3d& reference);

/// A bone between two joint centres goes to its new centres: `source_start` to `target_start`, `source_end` to
/// `target_end`, scaled along by the ratio of the lengths and across by `transverse_scale`. `rotation` says how it is
/// turned about its axis: its action on the source axis is first corrected by the smallest rotation.
Eigen::Affine3d bone_transform(const Eigen::Vector3d& source_start, const Eigen::Vector3d& source_end,
                               const Eigen::Vector3d& target_start, const Eigen::Vector3d& target_end,
                               const Eigen::Matrix3d& rotation, double transverse_scale);

}  // namespace ndg
