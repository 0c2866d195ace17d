// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/template.h"
#include "ndg/core/types.h"

#include <string>
#include <vector>

namespace ndg {

/// Anthropometric landmarks of a skin, found by their geometric definition (e.g. highest point of the head, foremost
/// point of the nose, most lateral point of the acromion region), the same on every source: `joint_positions` and dense
/// `weights` say which part of the skin is which. Left and right ones mirror each other. Positions are skin
/// vertices, those on the midline put onto x = 0.
/// Names follow ISO 7250-1 where it has one: vertex, glabella, nasal_tip, chin, opisthocranion, cervicale,
/// suprasternale, navel, crotch; and left_ and right_: ear, nipple, acromion, olecranon, wrist_radial, wrist_ulnar,
/// fingertip, trochanterion, buttock, patella, malleolus_lateral, malleolus_medial, metatarsal_1, metatarsal_5, heel,
/// toe_tip. Throws InputError naming a landmark whose part the skin lacks.
struct NamedPoint {
    std::string name;
    Eigen::Vector3d position;
};
std::vector<NamedPoint> skin_landmarks(const Eigen::Ref<const Points>& vertices,
                                       const Eigen::Ref<const RowMatrix>& weights,
                                       const Eigen::Ref<const Points>& joint_positions);

}  // namespace ndg
