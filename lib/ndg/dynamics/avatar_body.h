// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/avatar/avatar.h"
#include "ndg/dynamics/driven_body.h"

namespace ndg {

/// An avatar's layer of soft tissue with the same moduli everywhere, Pa.
SoftBody soft_body_of(const Avatar& avatar, double young_normal_pascal, double young_tangent_pascal);
/// Keeps a reference to the avatar.
SoftBodyPoser poser_of(const Avatar& avatar);

}  // namespace ndg
