// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"

#include <optional>
#include <vector>

namespace ndg {

/// How a mesh moves from its first frame to each, if it moves as a rigid body: every vertex within 20 um. `vertices`:
/// of all frames.
std::optional<std::vector<Eigen::Isometry3d>> rigid_motions(const std::vector<Points>& vertices);

}  // namespace ndg
