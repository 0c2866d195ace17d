// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/template.h"
#include "ndg/core/types.h"

#include <string>
#include <vector>

namespace ndg {

/// Anthropometric landmarks of a skin, found by their geometric definition (e.g. highest point of the head, foremost
/// point of the nose, most lateral point of the acromion region), the same on every source: `joint_positions` and dense
/// `weights` say which part of the skin is which. Left and right ones mirror each other. Positions lie on the skin.
struct NamedPoint {
    std::string name;
    Eigen::Vector3d position;
};
std::vector<NamedPoint> skin_landmarks(const Eigen::Ref<const Points>& vertices,
                                       const Eigen::Ref<const RowMatrix>& weights,
                                       const Eigen::Ref<const Points>& joint_positions);

}  // namespace ndg
