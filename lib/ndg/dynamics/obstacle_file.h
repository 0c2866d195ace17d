// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/json_file.h"
#include "ndg/dynamics/obstacle.h"

#include <string>
#include <vector>

namespace ndg {

/// The list "obstacles" of a scene. Each has "type" (plane, sphere, capsule, box, mesh) and where it is:
///   "name"; "position" [x, y, z] m; "rotation" [x, y, z], axis times angle in degrees; "velocity" m/s and
///   "angular_velocity" degrees/s, constant; or "keys", a list of {"time", "position", "rotation"}; "friction";
///   "follows": a joint, with which it moves, and the above is meant of the body at rest;
///   "free": true with "mass_kg", "young_pascal": thrown with the velocities above;
///   plane: "normal" instead of a rotation, "size", "edge"; sphere: "radius", "edge"; capsule, along its y axis:
///   "radius", "length" between the centres of its ends, "edge"; box: "size" [x, y, z],
///   "edge"; mesh: "file" beside the scene, closed, and "scale".
/// Lengths in metres. `folder`: of the scene file. Throws InputError naming file, place and value.
std::vector<Obstacle> read_obstacles(const JsonValue& list, const std::string& folder);

/// "[x, y, z]" of a scene.
Eigen::Vector3d read_vector(const JsonValue& value);

}  // namespace ndg
