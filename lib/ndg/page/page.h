// SPDX-License-Identifier: Apache-2.0
// A page of HTML that shows one body in motion, by one method or several, in any browser and without a network.
#pragma once

#include "ndg/deform/posed_body.h"

#include <functional>
#include <string>
#include <vector>

namespace ndg {

/// What a method makes of the body, frame by frame.
struct PageMethod {
    std::string name;
    std::function<Points(int frame_idx)> volume;  ///< N_v x 3; asked for in any order
    /// N_a x 3 of a posed body with that volume, where it is not PosedBody::anatomy that carries it. `rest`:
    /// anatomy_at_rest of the body.
    std::function<Points(const PosedBody& posed, const Points& rest, const Points& volume)> anatomy{};
};

struct PageMotion {
    std::string title;
    const Body* body = nullptr;
    std::vector<Pose> poses;          ///< one a frame
    double frame_rate = 30.0;         ///< Hz
    std::vector<PageMethod> methods;  ///< distances are to the first
    std::string credits;              ///< licence and credit lines of the data
};

/// What a page keeps of what it was given.
struct PageFigures {
    double largest_error = 0.0;  ///< m, of any vertex of bones and muscles in any frame, and of any surface
    int num_motions = 0;         ///< bones that move on their own
    int num_stored = 0;          ///< anatomy vertices that nothing carries
    int num_anatomy = 0;
};

/// Positions are stored in 16 bits within the reach of the body, the anatomy by what carries it (carried_anatomy.h).
/// Throws Error for a motion without body, frames or methods, or with a method of another number of vertices.
PageFigures write_page(const std::string& path, const BodyPoser& poser, const PageMotion& motion);

}  // namespace ndg
