// SPDX-License-Identifier: Apache-2.0
// One small example of every kind of file of the body module.
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/body/shape_space.h"
#include "ndg/body/template.h"
#include "support/h5_damage.h"

#include <string>

namespace ndg::test {

BodySet example_bodies(const Template& tube);
/// The skins of bodies.
SkinSet skins_of(const BodySet& bodies);
PoseSet example_poses();
ShapeSpace example_shape_space(const BodySet& bodies);

/// Writes the shape space with codes and errors of the bodies.
void write_example_shape_space(const std::string& path, const BodySet& bodies);

}  // namespace ndg::test
