// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/scene_surface.h"

#include "ndg/core/error.h"

namespace ndg {

void check_surface(const SceneSurface& surface)
{
    require(surface.vertices.rows() > 0 && surface.triangles.rows() > 0, "Surface \"{}\" is empty", surface.name);
    require(surface.vertices.allFinite(), "Surface \"{}\" has a vertex that is not finite", surface.name);
    require(surface.triangles.minCoeff() >= 0 && surface.triangles.maxCoeff() < surface.vertices.rows(),
            "Surface \"{}\" has a triangle index outside its {} vertices", surface.name, surface.vertices.rows());
    require(surface.opacity >= 0.0f && surface.opacity <= 1.0f && surface.edge_opacity <= 1.0f,
            "Surface \"{}\" has opacity {} (edge {}), which must lie in [0, 1]", surface.name, surface.opacity,
            surface.edge_opacity);
    require(surface.vertex_colours.rows() == 0 || surface.vertex_colours.rows() == surface.vertices.rows(),
            "Surface \"{}\" has {} vertex colours for {} vertices", surface.name, surface.vertex_colours.rows(),
            surface.vertices.rows());
}

}  // namespace ndg
