// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/io/motion.h"
#include "ndg/io/motion_text.h"

#include <nlohmann/json.hpp>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

using nlohmann::json;

constexpr int root_values = 8;  ///< duration, position, quaternion
/// Published clips hold interpolated quaternions of norm 0.8 to 1.1; one further off is no rotation.
constexpr double least_norm = 0.5, largest_norm = 2.0;

struct Character {
    std::vector<std::string> names;
    std::vector<int> parents;
    std::vector<int> num_values;  ///< of a frame's row: 4 (spherical), 1 (revolute about z), 0 (fixed); root: 0
    Points positions, tips;       ///< +y up, facing +x
};

/// The file faces +x with its right side at +z; ours faces +z with its left side at +x.
Eigen::Matrix3d ours_from_file()
{
    Eigen::Matrix3d turn;
    turn << 0, 0, -1, 0, 1, 0, 1, 0, 0;
    return turn;
}

json parse(const std::string& path)
{
    json root;
    try {
        root = json::parse(read_file(path));
    } catch (const json::exception& error) {
        throw InputError(fmt::format("{}: is not valid JSON: {}", path, error.what()));
    }
    require_input(root.is_object(), "{}: is not a JSON object", path);
    return root;
}

const json& need(const json& object, const char* key, const std::string& path, const std::string& where)
{
    require_input(object.is_object() && object.contains(key), "{}: {} has no \"{}\"", path, where, key);
    return object.at(key);
}

double need_number(const json& object, const char* key, const std::string& path, const std::string& where)
{
    const json& value = need(object, key, path, where);
    require_input(value.is_number(), "{}: \"{}\" of {} is {}, not a number", path, key, where, value.dump());
    return value.get<double>();
}

Eigen::RowVector3d attachment(const json& object, const std::string& path, const std::string& where)
{
    for (const char* key : {"AttachThetaX", "AttachThetaY", "AttachThetaZ"}) {
        const double angle = object.contains(key) ? need_number(object, key, path, where) : 0.0;
        require_input(angle == 0.0, "{}: \"{}\" of {} is {}, joints at an angle are not supported", path, key, where,
                      angle);
    }
    return {need_number(object, "AttachX", path, where), need_number(object, "AttachY", path, where),
            need_number(object, "AttachZ", path, where)};
}

int values_of_type(const std::string& type, const std::string& path, const std::string& where)
{
    if (type == "spherical") return 4;
    if (type == "revolute") return 1;
    require_input(type == "fixed", "{}: \"Type\" of {} is \"{}\", not spherical, revolute or fixed", path, where, type);
    return 0;
}

void add_joint(Character& character, const json& joint, const std::string& path)
{
    const int idx = static_cast<int>(character.names.size());
    const std::string where = fmt::format("joint {}", idx);
    const json& name = need(joint, "Name", path, where);
    const json& type = need(joint, "Type", path, where);
    require_input(name.is_string() && type.is_string(), "{}: \"Name\" or \"Type\" of {} is not text", path, where);
    const double id = need_number(joint, "ID", path, where), parent = need_number(joint, "Parent", path, where);
    require_input(id == idx, "{}: \"ID\" of {} is {}", path, where, id);
    const bool valid_parent = parent == std::floor(parent) && (idx == 0 ? parent == -1 : parent >= 0 && parent < idx);
    require_input(valid_parent, "{}: \"Parent\" of {} is {}", path, where, parent);
    require_input(std::find(character.names.begin(), character.names.end(), name) == character.names.end(),
                  "{}: two joints are named \"{}\"", path, name.get<std::string>());
    const Eigen::RowVector3d offset = attachment(joint, path, where);
    character.names.push_back(name.get<std::string>());
    character.parents.push_back(static_cast<int>(parent));
    character.num_values.push_back(idx == 0 ? 0 : values_of_type(type.get<std::string>(), path, where));
    character.positions.row(idx).setZero();
    if (idx > 0) character.positions.row(idx) = character.positions.row(character.parents[idx]) + offset;
}

Character read_character(const std::string& path)
{
    const json root = parse(path);
    const json& joints = need(need(root, "Skeleton", path, "the file"), "Joints", path, "\"Skeleton\"");
    require_input(joints.is_array() && !joints.empty(), "{}: \"Joints\" is no list of joints", path);
    Character character;
    character.positions.resize(static_cast<Eigen::Index>(joints.size()), 3);
    for (const json& joint : joints) add_joint(character, joint, path);

    // A joint's bone ends at the mean of its children, that of a last joint at the middle of its body's shape.
    character.tips = character.positions;
    std::vector<int> num_children(joints.size(), 0);
    for (std::size_t j = 1; j < joints.size(); ++j) {
        const int parent = character.parents[j];
        const Eigen::RowVector3d bone = character.positions.row(j) - character.positions.row(parent);
        ++num_children[parent];
        character.tips.row(parent) +=
            (bone - (character.tips.row(parent) - character.positions.row(parent))) / num_children[parent];
    }
    if (!root.contains("BodyDefs")) return character;
    require_input(root["BodyDefs"].is_array(), "{}: \"BodyDefs\" is no list", path);
    for (const json& body : root["BodyDefs"]) {
        const std::string where = "a body of \"BodyDefs\"";
        const json& name = need(body, "Name", path, where);
        const auto found = std::find(character.names.begin(), character.names.end(), name);
        if (found == character.names.end()) continue;
        const auto j = static_cast<std::size_t>(found - character.names.begin());
        if (num_children[j] == 0) character.tips.row(j) = character.positions.row(j) + attachment(body, path, where);
    }
    return character;
}

std::vector<double> row_values(const json& row, int frame_idx, int num_values, const std::string& path)
{
    require_input(row.is_array(), "{}: frame {} is no list of numbers", path, frame_idx);
    require_input(static_cast<int>(row.size()) == num_values, "{}: frame {} has {} values, the skeleton has {}", path,
                  frame_idx, row.size(), num_values);
    std::vector<double> values;
    for (const json& value : row) {
        require_input(value.is_number() && std::isfinite(value.get<double>()), "{}: value {} of frame {} is {}", path,
                      values.size(), frame_idx, value.dump());
        values.push_back(value.get<double>());
    }
    return values;
}

Eigen::Matrix3d quaternion_rotation(const double* wxyz, const std::string& joint, int frame_idx,
                                    const std::string& path)
{
    const Eigen::Quaterniond quaternion(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
    const double norm = quaternion.norm();
    require_input(norm >= least_norm && norm <= largest_norm, "{}: the quaternion of \"{}\" in frame {} has norm {}",
                  path, joint, frame_idx, norm);
    return quaternion.normalized().toRotationMatrix();
}

/// World rotations in the file's axes.
std::vector<Eigen::Matrix3d> world_rotations(const Character& character, const std::vector<double>& row, int frame_idx,
                                             const std::string& path)
{
    std::vector<Eigen::Matrix3d> world = {quaternion_rotation(&row[4], character.names[0], frame_idx, path)};
    std::size_t at = root_values;
    for (std::size_t j = 1; j < character.names.size(); ++j) {
        Eigen::Matrix3d local = Eigen::Matrix3d::Identity();
        if (character.num_values[j] == 4) {
            local = quaternion_rotation(&row[at], character.names[j], frame_idx, path);
        } else if (character.num_values[j] == 1) {
            local = axis_rotation('z', row[at]);
        }
        at += character.num_values[j];
        world.push_back(world[character.parents[j]] * local);
    }
    return world;
}

/// The median duration: the last frame of a clip has none, and a few clips hold one frame longer.
double find_frame_rate(std::vector<double> durations, const std::string& path)
{
    for (std::size_t f = 0; f < durations.size(); ++f) {
        require_input(durations[f] >= 0, "{}: the duration of frame {} is {}", path, f, durations[f]);
    }
    if (durations.size() > 1) durations.pop_back();
    std::nth_element(durations.begin(), durations.begin() + durations.size() / 2, durations.end());
    const double median = durations[durations.size() / 2];
    require_input(median > 0 && std::isfinite(1.0 / median),
                  "{}: the durations of its frames are {}, which gives no frame rate", path, median);
    return 1.0 / median;
}

}  // namespace

MotionClip read_deepmimic(const std::string& character_path, const std::string& motion_path)
{
    const Character character = read_character(character_path);
    const json root = parse(motion_path);
    const json& frames = need(root, "Frames", motion_path, "the file");
    require_input(frames.is_array() && !frames.empty(), "{}: has no frames", motion_path);
    int num_values = root_values;
    for (const int values : character.num_values) num_values += values;

    const Eigen::Matrix3d turn = ours_from_file();
    MotionClip clip;
    clip.name = file_stem(motion_path);
    clip.joint_names = character.names;
    clip.parents = character.parents;
    clip.zero_pose_positions = character.positions * turn.transpose();
    clip.zero_pose_tips = character.tips * turn.transpose();
    clip.metres_per_unit = 1.0;
    clip.axes_known = true;
    clip.root_positions.resize(static_cast<Eigen::Index>(frames.size()), 3);
    std::vector<double> durations;
    for (const json& frame : frames) {
        const int f = static_cast<int>(durations.size());
        const std::vector<double> row = row_values(frame, f, num_values, motion_path);
        durations.push_back(row[0]);
        clip.root_positions.row(f) = (turn * Eigen::Vector3d(row[1], row[2], row[3])).transpose();
        std::vector<Eigen::Matrix3d> world = world_rotations(character, row, f, motion_path);
        for (Eigen::Matrix3d& rotation : world) rotation = (turn * rotation * turn.transpose()).eval();
        clip.world_from_joint.push_back(std::move(world));
    }
    clip.frame_rate = find_frame_rate(durations, motion_path);
    return clip;
}

}  // namespace ndg
