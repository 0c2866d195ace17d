// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/skeleton.h"
#include "ndg/core/provenance.h"

#include <string>
#include <vector>

namespace ndg {

/// Poses on the standard skeleton, and the clip and frame each came from.
struct PoseSet {
    std::vector<Pose> poses;
    std::vector<int> clip_idx;   ///< per pose, into clip_names
    std::vector<int> frame_idx;  ///< per pose, frame of the clip's file
    std::vector<std::string> clip_names;
    std::vector<double> clip_frame_rates;  ///< Hz
    /// Covering radius after each pick (radians summed over joints); empty unless written by sample-poses.
    std::vector<double> covering_radius;

    /// Of poses put together of three others (splice_poses): clip and frame of trunk and head, of the arms, of the
    /// legs; -1 for the others. P x 6, or no rows where no pose is spliced.
    RowMatrixI spliced_from;

    bool is_spliced(int pose) const { return spliced_from.rows() > 0 && spliced_from(pose, 0) >= 0; }
    int size() const { return static_cast<int>(poses.size()); }
};

void write_poses(const std::string& path, const PoseSet& poses, const Provenance& provenance);
/// Checks shapes, index ranges and that every matrix is a rotation (InputError otherwise).
PoseSet read_poses(const std::string& path);

}  // namespace ndg
