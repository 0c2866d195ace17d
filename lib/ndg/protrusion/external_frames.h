// SPDX-License-Identifier: Apache-2.0
// Frames of other models, exported as meshes (docs/formats.md).
#pragma once

#include "ndg/protrusion/frame_protrusion.h"

#include <string>

namespace ndg {

/// Row of Table 3 for a folder of meshes. A frame is skin_<frame>.<ext>, a closed surface in metres, and any number of
/// <tissue>_<frame>.<ext> of what lies inside of it, in any format that read_mesh knows. Optional excluded.txt: indices
/// from 0, one a line, of the vertices of head, hands and toes on the skins, which must then all have one tessellation;
/// what lies nearest to them does not count. Throws InputError naming the file: no frame, a frame without skin or
/// without anything inside, an index out of range, a skin that is not closed or not outward.
ProtrusionRow external_protrusion(const std::string& method, const std::string& folder);

}  // namespace ndg
