// SPDX-License-Identifier: Apache-2.0
// Bones and muscles of one adult man: BodyParts3D (Mitsuhashi et al. 2009), as GLB files.
#pragma once

#include "ndg/body_source/template_source.h"

#include <string>
#include <vector>

namespace ndg {

/// Credit line stored in files made from this source.
extern const char* const bodyparts3d_licence;

/// What a file name says: "FJ838_BP63016_FMA24475_Left_femur.glb" is part "Left femur" with FMA id 24475.
struct BodyPartName {
    std::string name;
    int fma_id = 0;
    BodySide side = BodySide::middle;  ///< left or right when the name holds that word
};
/// Throws InputError when the name is not FJ<n>_BP<n>_FMA<id>_<words>.glb.
BodyPartName parse_body_part_name(const std::string& file_name);

struct BodyParts3DOptions {
    int bone_vertices = 37000;    ///< of all bones together, about (NDG section 3.1)
    int muscle_vertices = 97000;  ///< of all muscles and tendons together, about
};

/// All parts in the folders bones, muscles, other and tendons of `folder`, ordered by layer and name, as he stands:
/// millimetres turned to metres, y up, facing +z, the node rotation of the files left out, his plane of symmetry at
/// x = 0. The layer is "bone" for the folder bones and for the sternum, atlas and axis, which lie in `other`;
/// everything else is "muscle" (with its tendons, ligaments and membranes). Each part is closed and manifold
/// (repair_closed) and simplified to its share of the vertices, which grows with the part's area. `joint` is left
/// empty. Throws InputError naming the file.
std::vector<AnatomyMesh> read_bodyparts3d(const std::string& folder, const BodyParts3DOptions& options);

}  // namespace ndg
