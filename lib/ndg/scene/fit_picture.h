// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/scene/image.h"
#include "ndg/scene/scene_surface.h"

#include <string>

namespace ndg {

/// A surface fitted to scanned points, both in one place (metres, y up).
struct FitPicture {
    Points points;        ///< N x 3
    Points normals;       ///< N x 3, unit
    double spacing;       ///< of the points, m: each is drawn as a disc a little larger
    Points surface;       ///< M x 3
    Triangles triangles;  ///< of the surface
    double heading = 0;   ///< of the person about the vertical, radians
    std::string title, footer;
};

/// Three rows of pictures: the scan, the surface, and the surface coloured by the scan's signed distance from it (blue:
/// the scan lies inside, red: outside, in full colour at `range` metres, grey where no point is nearer than three times
/// that); front, back and left side.
Image fit_picture(const FitPicture& fit, double range, int height);

}  // namespace ndg
