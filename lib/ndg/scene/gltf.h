// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/scene/scene_surface.h"

#include <string>
#include <vector>

namespace ndg {

/// Writes a binary glTF 2.0 file with one named node, mesh and material a layer: metres, y up, vertex normals,
/// translucent layers alpha-blended and drawn last, vertex colours as COLOR_0. `copyright` goes into the asset record
/// (licence and credit lines). Temporary name, then rename. Throws Error for malformed or equally named layers.
void write_glb(const std::string& path, const std::vector<SceneSurface>& layers, const std::string& copyright = "");

}  // namespace ndg
