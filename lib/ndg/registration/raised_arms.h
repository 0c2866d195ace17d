// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/skeleton.h"
#include "ndg/scan/skin_places.h"

namespace ndg {

/// Whether an arm is turned so far that the skin at its shoulder tells little of the skin at rest.
bool raised_arms(const Pose& pose);

/// Of such arms, clavicle and arm get the joints of the likeliest person, on the spine that was found (J x 3 each).
void keep_raised_arms(const Pose& pose, const Points& likeliest, Points& joints);

/// N: 1 where the inverse of linear blend skinning gives the skin at rest, towards 0 around the shoulder of an arm that
/// is turned far: there it gives lumps, since skin does not move that way.
Eigen::VectorXd unposed_confidence(const SkinnedSurface& skin, const Pose& pose);

}  // namespace ndg
