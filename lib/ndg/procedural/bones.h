// SPDX-License-Identifier: Apache-2.0
// A simplified skeleton: each bone a closed surface joined from simple forms, placed by the same layout as the skin.
#pragma once

#include "ndg/body_source/template_source.h"
#include "ndg/procedural/field.h"
#include "ndg/procedural/layout.h"

#include <string>
#include <vector>

namespace ndg {

/// A bone before it is meshed.
struct BoneSketch {
    std::string name;                 ///< without the side
    std::string joint;                ///< of the left side for a paired bone
    int fma_left = 0, fma_right = 0;  ///< Foundational Model of Anatomy; equal for a middle bone, 0 where not known
    double edge_length = 0.006;       ///< m, of the mesh
    bool paired = true;               ///< drawn on the left, mirrored to the right
    Field field{};
};

std::vector<BoneSketch> head_bone_sketches(const BodyLayout& layout);
std::vector<BoneSketch> trunk_bone_sketches(const BodyLayout& layout);
std::vector<BoneSketch> limb_bone_sketches(const BodyLayout& layout);
std::vector<BoneSketch> hand_bone_sketches(const BodyLayout& layout);
std::vector<BoneSketch> foot_bone_sketches(const BodyLayout& layout);

/// All bones of a person: skull, mandible, 24 vertebrae, sacrum, ribs, sternum and the bones of the limbs, left and
/// right mirror images. Closed, outward, layer "bone". Deterministic.
std::vector<AnatomyMesh> procedural_bones(const BodyLayout& layout);

/// Mesh of one sketch (the left one of a pair).
AnatomyMesh mesh_bone(const BoneSketch& sketch);
/// The same on the other side.
AnatomyMesh mirrored_part(const AnatomyMesh& left, int fma_id);

}  // namespace ndg
