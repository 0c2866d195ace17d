// SPDX-License-Identifier: Apache-2.0
// A first joint map for a skeleton nobody has mapped yet, for the user to read and edit.
#pragma once

#include "ndg/retarget/reference_pose.h"

#include <string>
#include <vector>

namespace ndg {

struct JointMapProposal {
    JointMap map;
    std::vector<std::string> notes;       ///< what was guessed or not found, one sentence each
    std::string reference = "zero pose";  ///< pose in which it was made, or "frame 12"
    bool sides_from_names = false;        ///< left and right from the names rather than from where the feet point
};

/// The plane of symmetry is the one about which most joints of the zero pose have a mirror image; branches that mirror
/// each other from one common joint are limbs, the long pair nearest to the root the legs, the other the arms. Along a
/// limb joints are found by their names (words such as "knee", "calf" or "LowerLeg") and by where they lie against the
/// proportions of Drillis and Contini 1966; the spine and neck are shared evenly among the joints that the source has.
/// Up, front and unit of the file do not matter. Where the zero pose is no person who stands straight (Stance), joints
/// are found by names and lengths of bones, and then again in the frame that stands straightest, or in
/// `reference_frame`. A bone that ends in no joint is aligned only where it lies within 60 degrees of its parent's (a
/// hand), a foot only where it points forward of the shank. Throws InputError naming the clip where there are not two
/// such pairs of limbs, or a leg has no hip, knee and ankle.
JointMapProposal propose_joint_map(const MotionClip& clip, int reference_frame = find_reference_frame);

}  // namespace ndg
