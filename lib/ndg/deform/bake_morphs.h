// SPDX-License-Identifier: Apache-2.0
// The deformations of a clip as skinning with a few morphs before it, which any engine plays.
#pragma once

#include "ndg/body/skinning.h"

#include <functional>
#include <vector>

namespace ndg {

/// Distances over the vertices of a frame, m.
struct FrameError {
    double mean = 0, max = 0;
};

/// X = LBS(X_rest + sum_k w_k M_k) in every frame.
struct BakedMorphs {
    std::vector<Points> morphs;                       ///< K, N x 3 offsets at rest, m
    RowMatrix weights;                                ///< frames x K; the largest of each morph is 1 or -1
    std::vector<FrameError> errors, skinning_errors;  ///< a frame, with morphs and by skinning alone
};

/// A frame of the clip.
struct BakedFrame {
    std::vector<Eigen::Isometry3d> world_from_rest;
    Points vertices;  ///< N x 3, what shall come out
};

/// Principal components (not centred: at rest all weights are 0) of the offsets that skinning must be given to come out
/// right (rest_offsets.h), at most `max_morphs` and no more than there are frames; then the weights that are best in
/// each posed frame, by least squares. `frame` is asked for in ascending order, twice.
BakedMorphs bake_morphs(const Points& rest, const SkinningWeights& weights, int num_frames, int max_morphs,
                        const std::function<BakedFrame(int frame_idx)>& frame);

}  // namespace ndg
