// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/layer.h"

#include "ndg/core/error.h"

namespace ndg {

void check_layer(const Layer& layer)
{
    require(layer.vertices.rows() > 0 && layer.triangles.rows() > 0, "Layer \"{}\" is empty", layer.name);
    require(layer.vertices.allFinite(), "Layer \"{}\" has a vertex that is not finite", layer.name);
    require(layer.triangles.minCoeff() >= 0 && layer.triangles.maxCoeff() < layer.vertices.rows(),
            "Layer \"{}\" has a triangle index outside its {} vertices", layer.name, layer.vertices.rows());
    require(layer.opacity >= 0.0f && layer.opacity <= 1.0f && layer.edge_opacity <= 1.0f,
            "Layer \"{}\" has opacity {} (edge {}), which must lie in [0, 1]", layer.name, layer.opacity,
            layer.edge_opacity);
    require(layer.vertex_colours.rows() == 0 || layer.vertex_colours.rows() == layer.vertices.rows(),
            "Layer \"{}\" has {} vertex colours for {} vertices", layer.name, layer.vertex_colours.rows(),
            layer.vertices.rows());
}

}  // namespace ndg
