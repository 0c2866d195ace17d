// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/json_file.h"
#include "ndg/io/motion.h"
#include "ndg/io/motion_text.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

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

Eigen::RowVector3d attachment(const JsonValue& object)
{
    for (const char* key : {"AttachThetaX", "AttachThetaY", "AttachThetaZ"}) {
        if (!object.has(key)) continue;
        const JsonValue angle = object.at(key);
        angle.expect(angle.number() == 0.0, "0 (joints at an angle are not supported)");
    }
    return {object.at("AttachX").number(), object.at("AttachY").number(), object.at("AttachZ").number()};
}

void add_joint(Character& character, const JsonValue& joint)
{
    const int idx = static_cast<int>(character.names.size());
    const std::string name = joint.at("Name").text();
    const JsonValue id = joint.at("ID"), parent = joint.at("Parent");
    id.expect(id.number() == idx, std::to_string(idx));
    require_input(std::find(character.names.begin(), character.names.end(), name) == character.names.end(),
                  "{}: two joints are named \"{}\"", joint.where(), name);
    constexpr int values_of_type[] = {4, 1, 0};
    // The root's motion has numbers of its own, whatever its type says.
    const int num_values = idx == 0 ? 0 : values_of_type[joint.at("Type").choice({"spherical", "revolute", "fixed"})];
    const Eigen::RowVector3d offset = attachment(joint);
    character.names.push_back(name);
    character.parents.push_back(parent.integer(idx == 0 ? -1 : 0, idx - 1));
    character.num_values.push_back(num_values);
    character.positions.row(idx).setZero();
    if (idx > 0) character.positions.row(idx) = character.positions.row(character.parents[idx]) + offset;
}

Character read_character(const std::string& path)
{
    const JsonValue root(path);
    const std::vector<JsonValue> joints = root.at("Skeleton").at("Joints").elements();
    require_input(!joints.empty(), "{}: \"Joints\" is empty", path);
    Character character;
    character.positions.resize(static_cast<Eigen::Index>(joints.size()), 3);
    for (const JsonValue& joint : joints) add_joint(character, joint);

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
    if (!root.has("BodyDefs")) return character;
    for (const JsonValue& body : root.at("BodyDefs").elements()) {
        const auto found = std::find(character.names.begin(), character.names.end(), body.at("Name").text());
        if (found == character.names.end()) continue;
        const auto j = found - character.names.begin();
        if (num_children[j] == 0) character.tips.row(j) = character.positions.row(j) + attachment(body);
    }
    return character;
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
    const std::vector<JsonValue> frames = JsonValue(motion_path).at("Frames").elements();
    require_input(!frames.empty(), "{}: has no frames", motion_path);
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
    for (const JsonValue& frame : frames) {
        const int f = static_cast<int>(durations.size());
        const std::vector<double> row = frame.numbers(num_values);
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
