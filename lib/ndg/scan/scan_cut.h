// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"

#include <optional>
#include <string>
#include <vector>

namespace ndg {

/// A floor found under a scan.
struct ScanFloor {
    Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< unit, towards the person
    double offset = 0.0;                                ///< height of the plane along `normal`
    double area = 0.0;                                  ///< that the scan shows of it, in squared units
};

/// The floor that a person stands on: the plane with the largest area of `points` (N x 3, any unit) near it, if that is
/// more than soles have and all else lies on one side, at least half as high as long. None where there is no such
/// plane. The size of the scan sets all lengths.
std::optional<ScanFloor> find_floor(const Eigen::Ref<const Points>& points);
/// 1 for points above the floor, 0 for those that belong to it (within half a percent of the scan's size) or lie below.
std::vector<char> points_above_floor(const Eigen::Ref<const Points>& points, const ScanFloor& floor);

/// 1 for points of the person, 0 for stray parts: points connected by steps of at most some 3 % of the scan's size are
/// one part, and parts with less than `min_share` of the largest one's points are stray.
std::vector<char> points_of_person(const Eigen::Ref<const Points>& points, double min_share = 0.3);

/// Extents of points along the axes, between the 0.1 and 99.9 percentiles: a few stray points do not matter.
Eigen::Vector3d robust_extents(const Eigen::Ref<const Points>& points);

}  // namespace ndg
