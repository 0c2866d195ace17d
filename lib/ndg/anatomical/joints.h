// SPDX-License-Identifier: Apache-2.0
// Centres of rotation found on the bones themselves.
#pragma once

#include "ndg/body_source/bone_parts.h"

#include <array>
#include <map>
#include <string>
#include <vector>

namespace ndg {

/// A finger as our joints name it, its metacarpal bone's ordinal number and the words for it in names of phalanges.
struct FingerNames {
    const char *finger, *ordinal, *words;
};
constexpr std::array<FingerNames, 5> finger_names = {{{"thumb", "first", "thumb"},
                                                      {"index", "second", "index finger"},
                                                      {"middle", "third", "middle finger"},
                                                      {"ring", "fourth", "ring finger"},
                                                      {"pinky", "fifth", "little finger"}}};

/// Named points of a skeleton.
using BonePoints = std::map<std::string, Eigen::Vector3d>;

/// Points of the man as he stands (y up, facing +z, palms forward, left at +x), metres. Joints of the standard skeleton
/// under their names, where bones define them:
/// - thigh, upper_arm: centre of the sphere fitted to the head of femur and humerus;
/// - shin, forearm: middle between the epicondyles; foot: middle between the tips of the malleoli; clavicle: sternal
/// end
///   of the clavicle (Wu et al. 2002 and 2005, ISB recommendations); hand: middle of scaphoid and lunate, about which
///   the carpus turns on the forearm;
/// - fingers: centre of the head of the bone before the joint (thumb_1: base of the first metacarpal); toes: mean of
///   the heads of the metatarsals;
/// - spine_1..5, neck_1, neck_2: centres of the intervertebral disks below L4, L2, T12, T9, T7, C7, C4, the ones
/// nearest
///   to the joints of MakeHuman's rig; pelvis: middle between the hips; head: between the upper facets of the atlas;
///   jaw: middle between the condyles of the mandible.
/// Others: <side>_acromion_end (lateral end of the clavicle), <side>_medial_epicondyle and <side>_lateral_epicondyle
/// (of the humerus), <side>_ulnar_head, <side>_radial_head, <side>_<finger>_tip, <side>_toe_1..5 (heads of
/// the metatarsals) and <side>_toe_<n>_tip, <side>_heel, <side>_orbit. eyes and
/// forearm_twist are left out. Throws Error naming a missing bone.
BonePoints bone_points(const std::vector<AnatomyMesh>& parts);

}  // namespace ndg
