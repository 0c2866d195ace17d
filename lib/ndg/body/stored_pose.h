// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/skeleton.h"

namespace ndg {

/// The pose as read_poses gives it after write_poses, which rounds rotations to single precision: what uses poses at
/// once then makes of them what it makes of a file.
Pose as_stored(const Pose& pose);

}  // namespace ndg
