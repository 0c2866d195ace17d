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

    int size() const { return static_cast<int>(poses.size()); }
};

void write_poses(const std::string& path, const PoseSet& poses, const Provenance& provenance);
/// Checks shapes, index ranges and that every matrix is a rotation (InputError otherwise).
PoseSet read_poses(const std::string& path);

}  // namespace ndg
