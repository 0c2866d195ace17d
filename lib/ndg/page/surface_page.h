// SPDX-License-Identifier: Apache-2.0
// The page of page.h for a surface alone: nothing lies inside.
#pragma once

#include "ndg/core/types.h"

#include <functional>
#include <string>
#include <vector>

namespace ndg {

struct SurfacePageMotion {
    std::string title;
    Triangles triangles;  ///< among N points, fewer than 65536
    Points rest;          ///< N x 3, m
    int num_frames = 0;
    double frame_rate = 30.0;          ///< Hz
    std::vector<std::string> methods;  ///< distances are to the first
    /// N x 3 of a frame by a method; asked for several times.
    std::function<Points(int method_idx, int frame_idx)> points;
    /// The first so many points and triangles are the body, which is looked at and whose volume is told; others are
    /// what stands around it.
    int num_body_points = 0, num_body_triangles = 0;
    std::string credits;  ///< licence and credit lines of the data
};

/// Positions in 16 bits. Returns the largest error, m. Throws Error for no frames, no methods, or points that are not
/// N or not finite.
double write_surface_page(const std::string& path, const SurfacePageMotion& motion);

}  // namespace ndg
