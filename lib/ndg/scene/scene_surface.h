// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/colour.h"
#include "ndg/core/types.h"

#include <string>

namespace ndg {

/// A named surface as it is shown: rendered to a picture or written to a scene file.
struct SceneSurface {
    std::string name;
    Points vertices;                                             ///< metres, y up
    Triangles triangles;                                         ///< counter-clockwise from outside
    Eigen::Vector3f colour = Eigen::Vector3f(0.8f, 0.8f, 0.8f);  ///< sRGB in [0, 1]
    float opacity = 1.0f;                                        ///< seen face on; below 1 the surface is translucent
    float edge_opacity = -1.0f;      ///< opacity where the surface is seen edge on; negative: the same as `opacity`
    float gloss = 0.15f;             ///< strength of the highlight
    VertexColours vertex_colours{};  ///< empty: `colour` everywhere
    bool two_sided = true;           ///< also show triangles seen from behind
    /// A ray meets the surface once at most: of a translucent skin the outside shows, not the cavities behind it.
    bool outermost_only = false;
};

/// Throws Error naming the surface when indices, colours or opacity are out of range or a vertex is not finite.
void check_surface(const SceneSurface& surface);

}  // namespace ndg
