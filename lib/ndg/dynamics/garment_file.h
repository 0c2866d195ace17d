// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/json_file.h"
#include "ndg/dynamics/garment.h"

#include <string>
#include <vector>

namespace ndg {

/// The list "garments" of a scene. Each has "type":
///   sleeve: a tube about the line "from_joint" to "to_joint", "from" and "to" as shares of the way (0.25, 0.75),
///   "edge" and "offset" in metres;
///   mesh: "file" beside the scene, in the world as it starts, in metres, with "scale";
/// and for both "name", "rest_share" (0.9), "shrink_seconds", "young_pascal", "thickness" in metres, "density" in
/// kg/m^3, "friction". `folder`: of the scene file. Throws InputError naming file, place and value.
std::vector<GarmentPlan> read_garments(const JsonValue& list, const std::string& folder);

}  // namespace ndg
