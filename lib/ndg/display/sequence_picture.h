// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/options.h"
#include "ndg/export/mesh_sequence.h"
#include "ndg/scene/camera.h"
#include "ndg/scene/image.h"

namespace ndg {

struct SequencePictureOptions {
    int frames = 6;           ///< from the first to the last, evenly
    View view = View::right;  ///< of a body that faces +z
    int height = 600;         ///< pixels of one frame
};
void describe(OptionList& list, SequencePictureOptions& options);

/// Frames of a sequence side by side with their times. The first mesh, the body, fills the height in all of them
/// alike; of others what is beside it is seen. `labels`: above each frame in place of its time. Throws InputError for a
/// sequence without meshes or frames.
Image sequence_picture(const MeshSequence& sequence, const SequencePictureOptions& options,
                       const std::vector<std::string>& labels = {});

}  // namespace ndg
