// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/dynamics/garment.h"
#include "ndg/dynamics/obstacle.h"
#include "ndg/dynamics/scene_loads.h"

#include <string>
#include <vector>

namespace ndg {

/// What a body meets in a simulation (docs/formats.md, Scenes).
struct Scene {
    SceneLoads loads;
    bool contact = false;  ///< keeps skin from skin, also where there is nothing else
    std::vector<Obstacle> obstacles;
    std::vector<GarmentPlan> garments;
};
/// Reads JSON: {"gravity": bool, "contact": bool, "loads": [{"name", "center" or "joint", "radius_m", "mass_kg",
/// "from_s"}]}, "obstacles": [...] (obstacle_file.h), "garments": [...] (garment_file.h)}, all optional but what a load
/// needs. Throws InputError naming file, place and value; unknown keys are refused.
Scene read_scene(const std::string& path);

}  // namespace ndg
