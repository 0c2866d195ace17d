// SPDX-License-Identifier: Apache-2.0
// Whether anything passed through anything in bodies in motion, by winding numbers, frame by frame.
#pragma once

#include "ndg/display/dynamics_display.h"

#include <string>
#include <vector>

namespace ndg {

/// Vertices of one surface inside another, over the frames of a motion.
struct PenetrationCount {
    std::string inner, outer;
    /// Of skin that goes where skinning has it (head, hands, feet, rims), which contact does not hold back; otherwise
    /// of skin that gives way.
    bool held = false;
    int frames = 0;         ///< in which there are any
    int most_vertices = 0;  ///< in one frame
    double deepest_metre = 0;
    double deepest_seconds = 0;
};

/// Every obstacle and garment with the skin, both ways (nothing is inside a garment), soft and held skin apart, and the
/// skin with itself: what lies inside of another part of it, and what does so by skinning alone. Counts that are zero
/// are told too. Of skin with itself depth is to the nearest part that is farther off at rest than `apart` metres;
/// nothing is told of a skin that is not closed.
std::vector<PenetrationCount> count_penetrations(const DynamicsDisplay& display, int sequence, double apart = 0.05);

/// A line each.
std::string penetration_lines(const std::vector<PenetrationCount>& counts);
/// Throws QualityError for soft skin in an obstacle, or an obstacle or garment in soft skin.
void require_apart(const std::vector<PenetrationCount>& counts);

}  // namespace ndg
