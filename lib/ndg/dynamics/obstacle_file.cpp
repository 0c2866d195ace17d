// SPDX-License-Identifier: Apache-2.0
#include "ndg/dynamics/obstacle_file.h"

#include "ndg/core/angles.h"
#include "ndg/core/error.h"
#include "ndg/geometry/rotation.h"
#include "ndg/io/mesh.h"

#include <filesystem>
#include <set>

namespace ndg {

namespace {

constexpr double longest = 1e3, least_edge = 1e-3, most_triangles = 2e5;

double length_of(const JsonValue& value, const std::string& key, double fallback)
{
    return value.number_or(key, fallback, least_edge, longest);
}

/// An edge that makes no more triangles of the area than anyone can want.
double edge_of(const JsonValue& value, double fallback, double area)
{
    const double edge = length_of(value, "edge", fallback);
    require_input(area <= most_triangles * 0.43 * edge * edge, "{}: edges of {} m make more than {:.0f} triangles",
                  value.where(), edge, most_triangles);
    return edge;
}

Eigen::Quaterniond read_rotation(const JsonValue& value)
{
    return Eigen::Quaterniond(rotation_of(radians_per_degree * read_vector(value)));
}

ObstacleKey read_key(const JsonValue& value)
{
    ObstacleKey key;
    if (value.has("position")) key.position = read_vector(value.at("position"));
    if (value.has("rotation")) key.rotation = read_rotation(value.at("rotation"));
    return key;
}

TriangleMesh read_shape_file(const JsonValue& value, const std::string& folder)
{
    std::filesystem::path path(value.at("file").text());
    if (path.is_relative()) path = std::filesystem::path(folder) / path;
    MeshFile file = read_mesh(path.string());
    file.vertices *= value.number_or("scale", 1, 1e-6, 1e6);
    const std::string defect = closed_surface_defect(file.vertices, file.triangles);
    require_input(defect.empty(), "{}: {}: an obstacle must be closed and turned outwards: {}", value.where(),
                  path.string(), defect);
    return {file.vertices, file.triangles};
}

TriangleMesh read_shape(const JsonValue& value, int type, const std::string& folder)
{
    switch (type) {
        case 0: {
            const double size = length_of(value, "size", 4);
            return plane_shape(size, edge_of(value, size / 16, size * size));
        }
        case 1: {
            const double radius = value.at("radius").number(least_edge, longest);
            return sphere_shape(radius, edge_of(value, 0.3 * radius, 4 * M_PI * radius * radius));
        }
        case 2: {
            const double radius = value.at("radius").number(least_edge, longest);
            const double length = value.at("length").number(least_edge, longest);
            return capsule_shape(radius, length,
                                 edge_of(value, 0.4 * radius, 2 * M_PI * radius * (length + 2 * radius)));
        }
        case 3: {
            const Eigen::Vector3d size = read_vector(value.at("size"));
            value.at("size").expect(size.minCoeff() >= least_edge && size.maxCoeff() <= longest,
                                    fmt::format("three lengths in [{}, {}]", least_edge, longest));
            const double area = 2 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]);
            return box_shape(size, edge_of(value, 0.2 * size.maxCoeff(), area));
        }
        default:
            return read_shape_file(value, folder);
    }
}

std::vector<std::string> keys_of(int type)
{
    std::vector<std::string> keys{"name",     "type", "position", "velocity",     "angular_velocity",
                                  "friction", "free", "mass_kg",  "young_pascal", "follows"};
    const std::vector<std::string> more[] = {{"normal", "size", "edge"},
                                             {"rotation", "keys", "radius", "edge"},
                                             {"rotation", "keys", "radius", "length", "edge"},
                                             {"rotation", "keys", "size", "edge"},
                                             {"rotation", "keys", "file", "scale"}};
    keys.insert(keys.end(), more[type].begin(), more[type].end());
    if (type == 0) keys.push_back("keys");
    return keys;
}

void read_motion(const JsonValue& value, Obstacle& obstacle)
{
    if (value.has("keys")) {
        require_input(!value.has("position") && !value.has("rotation") && !value.has("normal"),
                      "{}: has both \"keys\" and a place", value.where());
        for (const JsonValue& element : value.at("keys").elements()) {
            element.check_keys({"time", "position", "rotation"});
            ObstacleKey key = read_key(element);
            key.time = element.at("time").number(0, 1e6);
            element.at("time").expect(obstacle.keys.empty() || key.time > obstacle.keys.back().time,
                                      "a time after that of the key before");
            obstacle.keys.push_back(key);
        }
        value.at("keys").expect(!obstacle.keys.empty(), "at least one key");
    } else {
        ObstacleKey key = read_key(value);
        if (value.has("normal")) {
            const Eigen::Vector3d normal = read_vector(value.at("normal"));
            value.at("normal").expect(normal.norm() > 0, "a direction");
            key.rotation = Eigen::Quaterniond(minimal_rotation(Eigen::Vector3d::UnitY(), normal));
        }
        obstacle.keys.push_back(key);
    }
    if (value.has("velocity")) obstacle.velocity = read_vector(value.at("velocity"));
    if (value.has("angular_velocity"))
        obstacle.angular_velocity = radians_per_degree * read_vector(value.at("angular_velocity"));
}

Obstacle read_obstacle(const JsonValue& value, std::size_t index, const std::string& folder)
{
    const std::vector<std::string> types{"plane", "sphere", "capsule", "box", "mesh"};
    const int type = value.at("type").choice(types);
    value.check_keys(keys_of(type));
    Obstacle obstacle;
    obstacle.name = value.text_or("name", fmt::format("{} {}", types[static_cast<std::size_t>(type)], index + 1));
    obstacle.shape = read_shape(value, type, folder);
    read_motion(value, obstacle);
    if (value.has("friction")) obstacle.friction = value.at("friction").number(0, 10);
    obstacle.follows = value.text_or("follows", "");
    obstacle.free = value.flag_or("free", false);
    if (!obstacle.free) {
        for (const char* key : {"mass_kg", "young_pascal"}) {
            require_input(!value.has(key), "{}: has \"{}\" but is not \"free\"", value.where(), key);
        }
        return obstacle;
    }
    require_input(obstacle.follows.empty(), "{}: what is free follows nothing", value.where());
    require_input(type != 0, "{}: a plane cannot be free", value.where());
    require_input(obstacle.keys.size() == 1, "{}: what is free has no \"keys\"", value.where());
    obstacle.mass_kg = value.at("mass_kg").number(1e-4, 1e4);
    obstacle.young_pascal = value.number_or("young_pascal", obstacle.young_pascal, 1e3, 1e9);
    try {
        solid_of(obstacle.shape, obstacle.mass_kg);
    } catch (const Error& error) {
        throw InputError(fmt::format("{}: cannot be free: {}", value.where(), error.what()));
    }
    return obstacle;
}

}  // namespace

Eigen::Vector3d read_vector(const JsonValue& value)
{
    const std::vector<double> numbers = value.numbers(3);
    return {numbers[0], numbers[1], numbers[2]};
}

std::vector<Obstacle> read_obstacles(const JsonValue& list, const std::string& folder)
{
    std::vector<Obstacle> obstacles;
    std::set<std::string> names;
    for (const JsonValue& value : list.elements()) {
        obstacles.push_back(read_obstacle(value, obstacles.size(), folder));
        require_input(names.insert(obstacles.back().name).second, "{}: a second obstacle \"{}\"", value.where(),
                      obstacles.back().name);
    }
    return obstacles;
}

}  // namespace ndg
