// SPDX-License-Identifier: Apache-2.0
// Bones and muscles of one person brought into the pose and proportions of another.
#pragma once

#include "ndg/anatomical/limbs.h"
#include "ndg/body_source/template_source.h"

#include <string>
#include <vector>

namespace ndg {

/// Which group of bones (AxialMap, limb_transforms) a bone moves with, and which joint of the standard skeleton.
struct BoneGroup {
    std::string group;  ///< "trunk", "head" or a key of limb_transforms
    std::string joint;
};
/// By the part's name. Throws Error for a bone that belongs to no group.
BoneGroup bone_group(const AnatomyMesh& bone);

/// Moves `parts` (as read_bodyparts3d gives them) into the target. Bones go with their group. A muscle's vertex goes
/// with a blend of the maps of those bone groups that the muscle touches (within 1 cm), weighted by the inverse cube of
/// the vertex's distance from their bones and smoothed along the muscle, so that attachments stay on the bones and what
/// lies between follows smoothly. Sets every bone's `joint`, and that of muscles that move with the hand's bones only.
/// Returns the centres of rotation by the bones, J x 3 on the standard skeleton, one side the mirror image of the
/// other; joints without bones (eyes) stay the target's.
Points register_anatomy(std::vector<AnatomyMesh>& parts, const AnatomyTarget& target);

/// The same joints with their sides made mirror images of each other (means of both), those in the middle at x = 0, and
/// the forearms' twist joints half way between elbow and wrist.
Points symmetric_joints(Points joint_positions);

/// Names of the joints that bones define: all but the eyes.
std::vector<std::string> bone_joint_names();

}  // namespace ndg
