// SPDX-License-Identifier: Apache-2.0
// Which joint of a limb is its shoulder, elbow, hand; hip, knee, foot.
#pragma once

#include "ndg/retarget/joint_map_names.h"

#include <string>
#include <vector>

namespace ndg {

/// A joint of ours to be found along a limb.
struct Role {
    std::string joint;  ///< without side
    /// Arms: distance from the plane of symmetry along the arm; legs: height of the standing body; shares of stature
    /// (Drillis and Contini 1966).
    double place;
    std::vector<std::string> words, weak_words, foreign_words;
    bool optional = false;
};

const std::vector<Role>& arm_roles();
const std::vector<Role>& leg_roles();

/// The joint of a chain for each role, in their order along it, -1 where one that is optional stays open; empty where
/// one that is not finds none. `places`: of the joints of the chain, as Role::place. Names count more than places.
std::vector<int> find_roles(const std::vector<Role>& roles, const std::vector<int>& chain,
                            const std::vector<double>& places, const std::vector<JointName>& names);

}  // namespace ndg
