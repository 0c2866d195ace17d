// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/scene/image.h"

#include <string>
#include <vector>

namespace ndg {

/// A layer of soft tissue below a skin, at rest, of a body that faces +z.
struct LayerPicture {
    TriangleMesh skin;  ///< closed
    Points vertices;    ///< of the tetrahedra
    Tetrahedra tetrahedra;
    Points joints;  ///< K x 3, drawn as bones where they lie near a section
    std::vector<int> parents;
    std::string title;
};

/// Sections with every tetrahedron outlined: a frontal one through the middle of the body, a sagittal one, and
/// horizontal ones at the heights given (m).
Image layer_picture(const LayerPicture& layer, const std::vector<double>& heights, int height);

}  // namespace ndg
