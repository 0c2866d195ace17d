// SPDX-License-Identifier: Apache-2.0
#include "ndg/dynamics/scene_file.h"

#include "ndg/core/error.h"
#include "ndg/core/json_file.h"
#include "ndg/dynamics/garment_file.h"
#include "ndg/dynamics/obstacle_file.h"

#include <filesystem>

namespace ndg {

namespace {

constexpr double largest_radius_m = 10, largest_mass_kg = 1000, longest_s = 1e5;

double positive(const JsonValue& value, double high)
{
    const double number = value.number();
    value.expect(number > 0 && number <= high, fmt::format("a number in (0, {}]", high));
    return number;
}

SceneLoad read_load(const JsonValue& value)
{
    value.check_keys({"name", "center", "joint", "radius_m", "mass_kg", "from_s"});
    SceneLoad load;
    load.name = value.at("name").text();
    value.expect(value.has("center") != value.has("joint"), "one of \"center\" and \"joint\"");
    if (value.has("center")) {
        const std::vector<double> center = value.at("center").numbers(3);
        load.center = Eigen::Vector3d(center[0], center[1], center[2]);
    } else {
        load.joint = value.at("joint").text();
    }
    load.radius_m = positive(value.at("radius_m"), largest_radius_m);
    load.mass_kg = positive(value.at("mass_kg"), largest_mass_kg);
    load.from_s = value.number_or("from_s", 0, 0, longest_s);
    return load;
}

}  // namespace

Scene read_scene(const std::string& path)
{
    const JsonValue root(path);
    root.check_keys({"gravity", "contact", "loads", "obstacles", "garments"});
    Scene scene;
    scene.loads.gravity = root.flag_or("gravity", false);
    scene.contact = root.flag_or("contact", false);
    if (root.has("loads")) {
        for (const JsonValue& load : root.at("loads").elements()) scene.loads.loads.push_back(read_load(load));
    }
    const std::string folder = std::filesystem::path(path).parent_path().string();
    if (root.has("obstacles")) scene.obstacles = read_obstacles(root.at("obstacles"), folder);
    if (root.has("garments")) scene.garments = read_garments(root.at("garments"), folder);
    return scene;
}

}  // namespace ndg
