// SPDX-License-Identifier: Apache-2.0
#include "ndg/dynamics/garment_file.h"

#include "ndg/core/error.h"
#include "ndg/io/mesh.h"

#include <filesystem>
#include <set>

namespace ndg {

namespace {

void read_sleeve(const JsonValue& value, GarmentPlan& plan)
{
    plan.from_joint = value.at("from_joint").text();
    plan.to_joint = value.at("to_joint").text();
    plan.from = value.number_or("from", plan.from, -1, 2);
    plan.to = value.number_or("to", plan.to, -1, 2);
    require_input(plan.from < plan.to, "{}: goes from {} to {} of the way", value.where(), plan.from, plan.to);
    plan.edge = value.number_or("edge", plan.edge, 2e-3, 0.2);
    plan.offset = value.number_or("offset", plan.offset, 1e-4, 0.05);
}

void read_mesh_file(const JsonValue& value, const std::string& folder, GarmentPlan& plan)
{
    std::filesystem::path path(value.at("file").text());
    if (path.is_relative()) path = std::filesystem::path(folder) / path;
    const MeshFile file = read_mesh(path.string());
    require_input(file.triangles.rows() > 0, "{}: {} has no triangles", value.where(), path.string());
    plan.mesh = {value.number_or("scale", 1, 1e-6, 1e6) * file.vertices, file.triangles};
    try {
        mesh_edges(plan.mesh.triangles, static_cast<int>(plan.mesh.vertices.rows()));
    } catch (const Error& error) {
        throw InputError(fmt::format("{}: {} is no cloth: {}", value.where(), path.string(), error.what()));
    }
}

GarmentPlan read_garment(const JsonValue& value, std::size_t index, const std::string& folder)
{
    const std::vector<std::string> types{"sleeve", "mesh"};
    const int type = value.at("type").choice(types);
    std::vector<std::string> keys{"type",         "name",      "rest_share", "shrink_seconds",
                                  "young_pascal", "thickness", "density",    "friction"};
    const std::vector<std::string> more[] = {{"from_joint", "to_joint", "from", "to", "edge", "offset"},
                                             {"file", "scale"}};
    keys.insert(keys.end(), more[type].begin(), more[type].end());
    value.check_keys(keys);
    GarmentPlan plan;
    plan.name = value.text_or("name", fmt::format("{} {}", types[static_cast<std::size_t>(type)], index + 1));
    if (type == 0) {
        read_sleeve(value, plan);
    } else {
        read_mesh_file(value, folder, plan);
    }
    plan.rest_share = value.number_or("rest_share", plan.rest_share, 0.1, 2);
    plan.shrink_seconds = value.number_or("shrink_seconds", plan.shrink_seconds, 0, 1e4);
    plan.material.young_pascal = value.number_or("young_pascal", plan.material.young_pascal, 1e2, 1e10);
    plan.material.thickness = value.number_or("thickness", plan.material.thickness, 1e-5, 0.05);
    plan.material.density = value.number_or("density", plan.material.density, 1, 2e4);
    if (value.has("friction")) plan.friction = value.at("friction").number(0, 10);
    return plan;
}

}  // namespace

std::vector<GarmentPlan> read_garments(const JsonValue& list, const std::string& folder)
{
    std::vector<GarmentPlan> plans;
    std::set<std::string> names;
    for (const JsonValue& value : list.elements()) {
        plans.push_back(read_garment(value, plans.size(), folder));
        require_input(names.insert(plans.back().name).second, "{}: a second garment \"{}\"", value.where(),
                      plans.back().name);
    }
    return plans;
}

}  // namespace ndg
