// SPDX-License-Identifier: Apache-2.0
// MakeHuman's rig and weights on the standard skeleton.
#pragma once

#include "ndg/core/types.h"

#include <map>
#include <string>
#include <vector>

namespace ndg {

/// Joint positions on the standard skeleton, J x 3: centres of MakeHuman's joint cubes; spine_4, neck_2 and the forearm
/// twist joints, which have no cube, lie between their neighbours. `all_vertices` includes the cubes' vertices.
/// Throws InputError for a missing cube.
Points makehuman_joint_positions(const Eigen::Ref<const Points>& all_vertices,
                                 const std::map<std::string, std::vector<int>>& joint_cubes);

/// Dense N x J weights of the body vertices from weights.game_engine.json; rows sum to one. The upper spine, neck and
/// forearm are divided over our finer chains; a few steps of smoothing along the surface take out the steps of the
/// game weights. Throws InputError naming file, bone and value.
RowMatrix makehuman_weights(const std::string& path, const Eigen::Ref<const Points>& vertices,
                            const Eigen::Ref<const Triangles>& triangles,
                            const Eigen::Ref<const Points>& joint_positions);

}  // namespace ndg
