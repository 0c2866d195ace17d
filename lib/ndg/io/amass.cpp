// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/io/motion.h"
#include "ndg/io/motion_text.h"
#include "ndg/io/npz.h"

#include <Eigen/Geometry>

#include <array>

namespace ndg {

namespace {

constexpr int num_joints = 22;
constexpr int body_values = 3 * (num_joints - 1);

struct RestJoint {
    const char* name;
    int parent;
    double x, y, z;  ///< from the parent, metres
};

/// The 22 body joints shared by SMPL, SMPL-H and SMPL-X, in their order, on a T pose of our own round proportions, y
/// up, facing +z, left at +x. Retargeting uses only the directions of bones; the proportions of SMPL's own bodies
/// depend on its licensed model and are not here.
constexpr std::array<RestJoint, num_joints> rest_joints = {
    {{"pelvis", -1, 0, 0, 0},         {"left_hip", 0, 0.09, -0.08, 0},      {"right_hip", 0, -0.09, -0.08, 0},
     {"spine1", 0, 0, 0.11, 0},       {"left_knee", 1, 0, -0.40, 0},        {"right_knee", 2, 0, -0.40, 0},
     {"spine2", 3, 0, 0.13, 0},       {"left_ankle", 4, 0, -0.42, 0},       {"right_ankle", 5, 0, -0.42, 0},
     {"spine3", 6, 0, 0.06, 0},       {"left_foot", 7, 0, -0.06, 0.13},     {"right_foot", 8, 0, -0.06, 0.13},
     {"neck", 9, 0, 0.22, 0},         {"left_collar", 9, 0.07, 0.12, 0},    {"right_collar", 9, -0.07, 0.12, 0},
     {"head", 12, 0, 0.09, 0},        {"left_shoulder", 13, 0.11, 0.03, 0}, {"right_shoulder", 14, -0.11, 0.03, 0},
     {"left_elbow", 16, 0.27, 0, 0},  {"right_elbow", 17, -0.27, 0, 0},     {"left_wrist", 18, 0.25, 0, 0},
     {"right_wrist", 19, -0.25, 0, 0}}};

/// Ends of the bones that carry no further joint.
Eigen::RowVector3d end_bone(const std::string& name)
{
    if (name == "head") return {0, 0.15, 0};
    if (name == "left_wrist") return {0.10, 0, 0};
    if (name == "right_wrist") return {-0.10, 0, 0};
    return {0, 0, 0.07};
}

void set_skeleton(MotionClip& clip)
{
    clip.zero_pose_positions = Points::Zero(num_joints, 3);
    clip.zero_pose_tips = Points::Zero(num_joints, 3);
    std::array<int, num_joints> num_children{};
    for (int j = 0; j < num_joints; ++j) {
        const RestJoint& joint = rest_joints[j];
        clip.joint_names.emplace_back(joint.name);
        clip.parents.push_back(joint.parent);
        if (joint.parent < 0) continue;
        clip.zero_pose_positions.row(j) =
            clip.zero_pose_positions.row(joint.parent) + Eigen::RowVector3d(joint.x, joint.y, joint.z);
        clip.zero_pose_tips.row(joint.parent) += clip.zero_pose_positions.row(j);
        ++num_children[joint.parent];
    }
    for (int j = 0; j < num_joints; ++j) {
        if (num_children[j] > 0)
            clip.zero_pose_tips.row(j) /= num_children[j];
        else
            clip.zero_pose_tips.row(j) = clip.zero_pose_positions.row(j) + end_bone(clip.joint_names[j]);
    }
}

/// Reads a table of `num_rows` (-1: any) times `num_columns` numbers (one of the list).
NpyArray read_table(const NpzFile& file, const std::string& key, std::int64_t num_rows,
                    const std::vector<std::int64_t>& num_columns)
{
    NpyArray array = file.read(key);
    bool fits = array.shape.size() == 2 && (num_rows < 0 || array.shape[0] == num_rows);
    bool known_width = false;
    for (const std::int64_t columns : num_columns) known_width |= fits && array.shape[1] == columns;
    fits = fits && known_width;
    const std::string rows = num_rows < 0 ? "frames" : std::to_string(num_rows);
    require_input(fits, "{}: \"{}\" has the shape ({}), ({}, {}) is needed", file.path(), key,
                  fmt::join(array.shape, ", "), rows, fmt::join(num_columns, " or "));
    require_input(array.shape[0] > 0, "{}: \"{}\" has 0 frames", file.path(), key);
    return array;
}

/// Frames x 66 axis-angles of the root and the 21 body joints.
Eigen::Matrix<double, Eigen::Dynamic, 3 * num_joints, Eigen::RowMajor> read_axis_angles(const NpzFile& file)
{
    using Table = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
    const auto table = [](const NpyArray& array) { return Table(array.values.data(), array.shape[0], array.shape[1]); };
    if (file.has("root_orient")) {
        const NpyArray root = read_table(file, "root_orient", -1, {3});
        const NpyArray body = read_table(file, "pose_body", root.shape[0], {body_values});
        Eigen::Matrix<double, Eigen::Dynamic, 3 * num_joints, Eigen::RowMajor> angles(root.shape[0], 3 * num_joints);
        angles << table(root), table(body);
        return angles;
    }
    // SMPL has 24 joints, SMPL-H 52, SMPL-X 55; all begin with the same 22.
    const NpyArray poses = read_table(file, "poses", -1, {72, 156, 165});
    return table(poses).leftCols(3 * num_joints);
}

double read_frame_rate(const NpzFile& file)
{
    const std::string key = file.has("mocap_frame_rate") ? "mocap_frame_rate" : "mocap_framerate";
    const NpyArray rate = file.read(key);
    require_input(rate.values.size() == 1, "{}: \"{}\" has {} values instead of 1", file.path(), key,
                  rate.values.size());
    require_input(rate.values[0] > 0, "{}: \"{}\" is {}", file.path(), key, rate.values[0]);
    return rate.values[0];
}

/// No writer turns a joint by so many radians; far larger ones lose all digits of the rotation.
constexpr double largest_angle = 1000.0;

Eigen::Matrix3d axis_angle_rotation(const Eigen::Vector3d& axis_angle, const std::string& path, Eigen::Index frame_idx,
                                    const char* joint)
{
    const double angle = axis_angle.norm();
    require_input(angle <= largest_angle, "{}: \"{}\" turns by {} radians in frame {}", path, joint, angle, frame_idx);
    if (angle == 0.0) return Eigen::Matrix3d::Identity();
    return Eigen::AngleAxisd(angle, axis_angle / angle).toRotationMatrix();
}

}  // namespace

bool is_amass(const std::string& path)
{
    const NpzFile file(path);
    return file.has("trans") && (file.has("poses") || file.has("root_orient"));
}

MotionClip read_amass(const std::string& path)
{
    const NpzFile file(path);
    const auto angles = read_axis_angles(file);
    const NpyArray trans = read_table(file, "trans", angles.rows(), {3});

    MotionClip clip;
    clip.name = file_stem(path);
    clip.frame_rate = read_frame_rate(file);
    clip.metres_per_unit = 1.0;
    clip.axes_known = true;
    set_skeleton(clip);
    Eigen::Matrix3d ours_from_file;  // z up to y up
    ours_from_file << 1, 0, 0, 0, 0, 1, 0, -1, 0;
    clip.root_positions.resize(angles.rows(), 3);
    for (Eigen::Index f = 0; f < angles.rows(); ++f) {
        clip.root_positions.row(f) =
            (ours_from_file * Eigen::Map<const Eigen::Vector3d>(trans.values.data() + 3 * f)).transpose();
        std::vector<Eigen::Matrix3d> world;
        for (int j = 0; j < num_joints; ++j) {
            const Eigen::Matrix3d local =
                axis_angle_rotation(angles.row(f).segment<3>(3 * j).transpose(), path, f, rest_joints[j].name);
            const int parent = rest_joints[j].parent;
            // The root's rotation takes the model, which stands y up, into the file's world.
            world.push_back((parent < 0 ? ours_from_file : world[parent]) * local);
        }
        clip.world_from_joint.push_back(std::move(world));
    }
    return clip;
}

}  // namespace ndg
