// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/skeleton.h"

#include <array>
#include <vector>

namespace ndg {

/// Standing upright with hanging arms, palms towards the thighs, knees, elbows and fingers straight, feet as at rest.
struct NeutralPosture {
    std::vector<Eigen::Matrix3d> world_from_rest;  ///< J rotations of each joint's surroundings from rest
    /// Left and right: columns are axes of the thumb; it bends about z and points along -y.
    std::array<Eigen::Matrix3d, 2> thumb_frames;
};

/// `joint_positions`: J x 3 rest positions on the standard skeleton. Throws InputError where a limb bone has no length.
NeutralPosture find_neutral_posture(const Eigen::Ref<const Points>& joint_positions);

}  // namespace ndg
