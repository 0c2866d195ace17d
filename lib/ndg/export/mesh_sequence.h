// SPDX-License-Identifier: Apache-2.0
// What is exported, in terms that hold for any body, scan or simulation. Writers see nothing else.
#pragma once

#include "ndg/core/colour.h"
#include "ndg/core/types.h"
#include "ndg/export/rig.h"
#include "ndg/export/volume_sequence.h"

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace ndg {

/// What one mesh keeps in all frames.
struct ExportedMesh {
    std::string name;
    Triangles triangles;                                         ///< counter-clockwise from outside
    Eigen::Vector3f colour = Eigen::Vector3f(0.8f, 0.8f, 0.8f);  ///< sRGB in [0, 1]
    float opacity = 1.0f;                                        ///< below 1 it is translucent
    float gloss = 0.15f;                                         ///< strength of the highlight, 0 to 1
    bool two_sided = true;                                       ///< also show triangles seen from behind
    std::string group{};  ///< of meshes that belong together ("bones"); empty: none
    int fma_id = 0;       ///< Foundational Model of Anatomy; 0 for none
};

/// One mesh in one frame.
struct MeshFrame {
    Points vertices;                                   ///< N x 3, metres, y up; N is the same in all frames
    VertexColours colours{};                           ///< N x 3; empty: the mesh's colour everywhere
    std::map<std::string, Eigen::VectorXf> scalars{};  ///< by name, N each
};

/// Named meshes that move.
struct MeshSequence {
    std::vector<ExportedMesh> meshes;
    int num_frames = 1;
    double frame_rate = 30.0;  ///< Hz
    /// One entry a mesh. Asked for in ascending order, each frame once, so that sequences of any length stream.
    std::function<std::vector<MeshFrame>(int frame_idx)> frame;
    std::string credits;  ///< licence and credit lines of the data
    /// What moves one of the meshes, in formats that know skeletons.
    std::optional<Rig> rig{};
    /// Without gaps, for formats that hold several; empty: one, "motion".
    std::vector<RigClip> clips{};
    /// What formats of volumes hold; they leave out the meshes.
    std::optional<VolumeSequence> volume{};
};

}  // namespace ndg
