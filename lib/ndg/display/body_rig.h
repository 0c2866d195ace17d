// SPDX-License-Identifier: Apache-2.0
// A body's skin on its skeleton, for engines and animation programs.
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/core/options.h"
#include "ndg/deform/bake_morphs.h"
#include "ndg/deform/posed_body.h"
#include "ndg/export/mesh_sequence.h"

#include <functional>
#include <string>
#include <vector>

namespace ndg {

/// none: every frame's vertices. skinning: the skin by linear blend skinning alone. morphs: with morphs fitted to the
/// frames' deformations.
enum class RigKind { none, skinning, morphs };
template <>
inline constexpr EnumName<RigKind> enum_table<RigKind>[] = {
    {RigKind::none, "none"}, {RigKind::skinning, "skinning"}, {RigKind::morphs, "morphs"}};

struct RigOptions {
    RigKind kind = RigKind::none;
    int influences = 4;  ///< joints a vertex, 4 or 8
    int morphs = 16;     ///< at most

    /// Throws InputError.
    void check() const;
};
void describe(OptionList& list, RigOptions& options);

/// What is on the skeleton, and how near it comes.
struct BodyRig {
    Rig rig;                  ///< mesh_idx is the caller's
    SkinningWeights weights;  ///< those of the rig
    BakedMorphs baked;        ///< empty without morphs
};

/// `skin`: a frame's deformed skin, N_s x 3, asked for where there are morphs.
BodyRig body_rig(const BodyPoser& poser, const Body& body, const std::vector<Pose>& poses, const RigOptions& options,
                 const std::function<Points(int frame_idx)>& skin);

/// Successive poses of one clip each, with their rates.
std::vector<RigClip> pose_clips(const PoseSet& poses, const std::vector<int>& pose_indices);

/// JSON: morphs, influences and, by skinning and with morphs, mean and max of each frame and of all, in mm.
std::string bake_report(const BodyRig& rig, const RigOptions& options);
/// The same as a table of at most `rows` frames, evenly spread, the worst among them.
std::string bake_table(const BakedMorphs& baked, int rows = 12);

}  // namespace ndg
