// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/skeleton.h"

#include <vector>

namespace ndg {

/// Distance of two poses in radians: the sum over all joints of the angle between their local rotations (NDG 4.1).
/// Root translations do not count. A metric.
double pose_distance(const Pose& a, const Pose& b);

/// Root rotation to identity and root translation to zero: without gravity a quasi-static body deforms alike in every
/// placement, so two poses that differ by the root alone are one pose.
void remove_root_motion(Pose& pose);

/// The poses with all joints at rest but the root and those marked 1 (J entries), so that the others add nothing to
/// distances. Throws InputError for another number of joints.
std::vector<Pose> with_marked_joints(std::vector<Pose> poses, const std::vector<int>& marked);

struct PoseSampling {
    std::vector<int> order;               ///< picked poses in order
    std::vector<double> covering_radius;  ///< after each pick: largest distance of any pose to the nearest picked one
};

/// Farthest-point sampling (Gonzalez 1985): each next pick is the pose farthest from all picked ones, the lowest index
/// where several are equally far. Exact: a distance is left out only where a lower bound of it (the triangle inequality
/// between picks, or a sum in float32 with its rounding taken off) shows that the pose comes no nearer. The result does
/// not depend on the number of threads. `first`: the picks to begin with, in their order, at least one and at most
/// `count`; `count` counts them. Throws InputError for a count outside 1..poses, an index out of range, or when fewer
/// than `count` poses differ.
PoseSampling farthest_point_sampling(const std::vector<Pose>& poses, int count, const std::vector<int>& first);

}  // namespace ndg
