// SPDX-License-Identifier: Apache-2.0
// A first joint map for a skeleton nobody has mapped yet, for the user to read and edit.
#pragma once

#include "ndg/retarget/joint_map.h"

#include <string>
#include <vector>

namespace ndg {

struct JointMapProposal {
    JointMap map;
    std::vector<std::string> notes;  ///< what was guessed or not found, one sentence each
    bool sides_from_names = false;   ///< left and right from the names rather than from where the feet point
};

/// The plane of symmetry is the one about which most joints of the zero pose have a mirror image; branches that mirror
/// each other from one common joint are limbs, the long pair nearest to the root the legs, the other the arms. Along a
/// limb joints are found by their names (words such as "knee", "calf" or "LowerLeg") and by where they lie against the
/// proportions of Drillis and Contini 1966; the spine and neck are shared evenly among the joints that the source has.
/// Up, front and unit of the file do not matter. Throws InputError naming the clip where there are not two such pairs
/// of limbs, or a leg has no hip, knee and ankle.
JointMapProposal propose_joint_map(const MotionClip& clip);

}  // namespace ndg
