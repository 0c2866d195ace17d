// SPDX-License-Identifier: Apache-2.0
// Poses of a capture as what drives a simulation.
#pragma once

#include "ndg/capture/capture.h"

#include <vector>

namespace ndg {

/// Poses at the step rate, from the sequence's first frame to its last; frame number n is pose
/// (n - first) * steps_per_frame, exactly. Poses of missing frames lie between their neighbours; between frames run
/// Catmull-Rom's cubics of root and unit quaternions, without the kinks that straight lines have and flesh feels.
/// Throws InputError where the sequence has no poses or its frame rate does not divide the step rate.
std::vector<Pose> step_poses(const CaptureSequence& sequence, double step_rate_hertz);

/// Throws InputError where the frame rate does not divide the step rate.
int steps_per_frame(const CaptureSequence& sequence, double step_rate_hertz);

}  // namespace ndg
