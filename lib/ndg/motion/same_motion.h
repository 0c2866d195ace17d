// SPDX-License-Identifier: Apache-2.0
// Whether two clips hold the same motion.
#pragma once

#include "ndg/body/pose_set.h"

namespace ndg {

/// Poses [first, first + count) of a set.
struct PoseRange {
    const PoseSet* poses = nullptr;
    int first = 0, count = 0;
};

/// How two motions are compared.
struct SameMotionOptions {
    /// rad: mean difference of the directions of arms and legs, seen from the root, and of the root's turn since the
    /// first pose, up to this. Twists, and where the motion faces, are a rig's own affair.
    double angle = 1e-3;
    double way = 1e-3;      ///< m: mean difference of the root's place from that of the first pose
    int largest_shift = 0;  ///< poses by which one may begin later (and one may be longer by)
    int least_poses = 1;    ///< shorter motions are never the same
};

/// Of a clip and its copy on the same rig, but for rounding.
inline SameMotionOptions same_rig()
{
    return {};
}
/// Of one take in two formats, on rigs whose rest poses differ by a few degrees.
inline SameMotionOptions other_rig()
{
    return {4.0 * 3.141592653589793 / 180.0, 0.03, 1, 8};
}

/// Compares up to 64 poses, evenly spaced.
bool same_motion(const PoseRange& a, const PoseRange& b, const SameMotionOptions& options);

}  // namespace ndg
