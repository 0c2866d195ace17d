// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body_source/parametric_surface.h"

#include <string>

namespace ndg {

/// A skin that can become a template: one closed manifold surface, outward, in metres, standing on y = 0, facing +z.
/// Repaired with a warning in the log: a skin that faces inwards is turned, one in millimetres, centimetres or
/// decimetres (a stature of 1.2 to 2.3 m says which) is scaled with its joints, one off the floor is put on it.
/// Throws InputError, one sentence naming `name` and the place, for a skin that is open, non-manifold or in several
/// parts, has no adult's stature or volume, is not upright, faces another way, or has joints outside of it.
ParametricSurface checked_skin(ParametricSurface skin, const std::string& name);

}  // namespace ndg
