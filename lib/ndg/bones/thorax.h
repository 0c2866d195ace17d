// SPDX-License-Identifier: Apache-2.0
// Sternum, ribs and their cartilages in a pose.
#pragma once

#include "ndg/bones/bone_names.h"
#include "ndg/core/types.h"

#include <array>

namespace ndg {

/// The sternum moves with the mean of the vertebrae that carry it by their ribs.
Eigen::Isometry3d sternum_motion(const std::array<Eigen::Isometry3d, num_vertebrae>& vertebrae,
                                 const Eigen::Vector3d& sternum_centre);

/// A rib or a cartilage: a bar whose two ends are carried by two bones.
struct Strut {
    Eigen::Vector3d first, second;  ///< ends at rest
    double second_share = 1.0;      ///< 1: points to where the second bone takes its end; 0: moves with the first alone
};
/// Keeps the first end on its bone and turns, by the least rotation, to where the second bone has the other end.
Eigen::Isometry3d strut_motion(const Strut& strut, const Eigen::Isometry3d& first_bone,
                               const Eigen::Isometry3d& second_bone);

/// How far the sternum leads the front end of a rib (1 to 12): true ribs 1, the three below through their cartilages,
/// floating ribs 0.
double sternum_share(int rib);

}  // namespace ndg
