// SPDX-License-Identifier: Apache-2.0
// Bodies with what lies inside as a sequence of meshes for other programs.
#pragma once

#include "ndg/core/provenance.h"
#include "ndg/export/mesh_sequence.h"
#include "ndg/scene/pictures.h"

#include <functional>
#include <string>
#include <vector>

namespace ndg {

/// What meshes hold; "parts": all, with each bone and muscle as a mesh of its own.
inline const std::vector<std::string> body_mesh_choices = {"all",       "parts", "skin",   "muscle_wrap",
                                                           "bone_wrap", "bones", "muscles"};

/// A body in one frame.
struct BodyFrame {
    const Body* body = nullptr;
    BodyGeometry geometry;
};

/// `num_frames` frames of bodies, each asked for when it is written. `choice`: one of body_mesh_choices. With
/// settings.volume_colours the skin has colours and the scalar "volume_change". Frame rate and credits are the
/// caller's. Keeps a reference to the template. Throws InputError for a choice that the template lacks.
MeshSequence body_meshes(const Template& body_template, const std::string& choice, const PictureSettings& settings,
                         int num_frames, const std::function<BodyFrame(int frame_idx)>& frame);

/// Licence and credit lines of all inputs and of the tool itself, each once.
std::string credits_of(const Provenance& provenance);

}  // namespace ndg
