// SPDX-License-Identifier: Apache-2.0
// Offsets at rest that are linear in the pose (pose blend shapes; Loper et al. 2015).
#pragma once

#include "ndg/body/skeleton.h"
#include "ndg/core/types.h"

#include <vector>

namespace ndg {

/// The entries of R_j - I row by row, joint after joint; 9 P.
Eigen::VectorXd pose_features(const Pose& pose, const std::vector<int>& joints);

/// N x 3, m: the sum of the directions (9 P x 3 N), each times its feature. Summed in double and in one order, so that
/// equal directions give equal offsets whatever stands beside them.
Points pose_offsets(const Eigen::Ref<const Eigen::VectorXd>& features, const RowMatrixF& directions);

}  // namespace ndg
