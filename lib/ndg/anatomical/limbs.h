// SPDX-License-Identifier: Apache-2.0
// Limb bones brought to the joints of another person in another pose.
#pragma once

#include "ndg/anatomical/trunk.h"

#include <map>
#include <string>
#include <vector>

namespace ndg {

/// One affine map for every group of limb bones that moves as one, by name: <side>_ clavicle, scapula, upper_arm, ulna,
/// radius, carpus, thigh, shin, foot, toe_1..5, and for each finger <finger>_0 (metacarpal) to <finger>_3 (the thumb to
/// _2).
/// - Long bones go from joint centre to joint centre, scaled along by the ratio of the lengths, across by the mean of
///   that and the stature's.
/// - The humerus is turned about itself so that the elbow's axis (through the epicondyles) is square to the plane of
/// the
///   target's bent arm; the radius turns about the line from its head to the ulna's as far as the hand's knuckles ask.
/// - The scapula takes the head of the humerus to the target's shoulder, is turned until its middle lies in the
/// direction
///   where the trunk's map takes it, on the ribs, and then upward by the scapula's share of the arm's elevation, a
///   third (Inman et al. 1944).
/// - The foot is fitted to the sole, heel, toes and sides of the target's foot, each toe to the tip of its own: the
/// five
///   foremost bulges of the skin.
std::map<std::string, Eigen::Affine3d> limb_transforms(const std::vector<AnatomyMesh>& parts, const BonePoints& points,
                                                       const AxialMap& trunk, const AnatomyTarget& target);

}  // namespace ndg
