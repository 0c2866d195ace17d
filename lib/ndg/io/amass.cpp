// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/io/motion.h"
#include "ndg/io/motion_text.h"
#include "ndg/io/npz.h"
#include "ndg/io/smpl_skeleton.h"

#include <Eigen/Geometry>

#include <array>

namespace ndg {

namespace {

constexpr int num_body_joints = 22;
constexpr int num_hand_joints = 15;  ///< of one hand
constexpr int body_values = 3 * (num_body_joints - 1);
constexpr int hand_values = 3 * 2 * num_hand_joints;

struct RestJoint {
    const char* name;
    int parent;
    double x, y, z;  ///< from the parent, metres
};

/// The joints that SMPL-H and SMPL-X share, in SMPL-H's order, on a T pose of our own round proportions, y up, facing
/// +z, left at +x, palms down. The proportions of SMPL's own bodies depend on its licensed model and are not here
/// (SmplSkeleton reads them).
constexpr std::array<RestJoint, num_body_joints> body_joints = {
    {{"pelvis", -1, 0, 0, 0},         {"left_hip", 0, 0.09, -0.08, 0},      {"right_hip", 0, -0.09, -0.08, 0},
     {"spine1", 0, 0, 0.11, 0},       {"left_knee", 1, 0, -0.40, 0},        {"right_knee", 2, 0, -0.40, 0},
     {"spine2", 3, 0, 0.13, 0},       {"left_ankle", 4, 0, -0.42, 0},       {"right_ankle", 5, 0, -0.42, 0},
     {"spine3", 6, 0, 0.06, 0},       {"left_foot", 7, 0, -0.06, 0.13},     {"right_foot", 8, 0, -0.06, 0.13},
     {"neck", 9, 0, 0.22, 0},         {"left_collar", 9, 0.07, 0.12, 0},    {"right_collar", 9, -0.07, 0.12, 0},
     {"head", 12, 0, 0.09, 0},        {"left_shoulder", 13, 0.11, 0.03, 0}, {"right_shoulder", 14, -0.11, 0.03, 0},
     {"left_elbow", 16, 0.27, 0, 0},  {"right_elbow", 17, -0.27, 0, 0},     {"left_wrist", 18, 0.25, 0, 0},
     {"right_wrist", 19, -0.25, 0, 0}}};

/// Joints of the left hand; `parent` within the hand, -1 for the wrist.
constexpr std::array<RestJoint, num_hand_joints> hand_joints = {{{"index1", -1, 0.09, 0, 0.025},
                                                                 {"index2", 0, 0.04, 0, 0},
                                                                 {"index3", 1, 0.025, 0, 0},
                                                                 {"middle1", -1, 0.09, 0, 0},
                                                                 {"middle2", 3, 0.045, 0, 0},
                                                                 {"middle3", 4, 0.03, 0, 0},
                                                                 {"pinky1", -1, 0.08, 0, -0.04},
                                                                 {"pinky2", 6, 0.03, 0, 0},
                                                                 {"pinky3", 7, 0.02, 0, 0},
                                                                 {"ring1", -1, 0.085, 0, -0.02},
                                                                 {"ring2", 9, 0.04, 0, 0},
                                                                 {"ring3", 10, 0.025, 0, 0},
                                                                 {"thumb1", -1, 0.03, -0.015, 0.03},
                                                                 {"thumb2", 12, 0.03, -0.01, 0.03},
                                                                 {"thumb3", 13, 0.025, -0.005, 0.02}}};

/// Ends of the bones that carry no further joint, from there.
Eigen::RowVector3d end_bone(const std::string& name)
{
    const double side = name.compare(0, 4, "left") == 0 ? 1.0 : -1.0;
    if (name == "head") return {0, 0.15, 0};
    if (name == "left_foot" || name == "right_foot") return {0, 0, 0.07};
    if (name.find("wrist") != std::string::npos) return {side * 0.10, 0, 0};
    if (name.find("thumb") != std::string::npos) return {side * 0.025, 0, 0.015};
    return {side * 0.02, 0, 0};
}

/// Zero pose of the body joints, with those of the hands behind them. `model`: M x 3 joints of a body model, or
/// nothing.
void set_skeleton(MotionClip& clip, bool with_hands, const Points& model)
{
    std::vector<Eigen::RowVector3d> offsets;
    const auto add = [&](const std::string& name, int parent, const Eigen::RowVector3d& offset) {
        clip.joint_names.push_back(name);
        clip.parents.push_back(parent);
        offsets.push_back(offset);
    };
    for (const RestJoint& joint : body_joints) add(joint.name, joint.parent, {joint.x, joint.y, joint.z});
    for (const double side : {1.0, -1.0}) {
        if (!with_hands) break;
        const std::string prefix = side > 0 ? "left_" : "right_";
        const int first = static_cast<int>(offsets.size()), wrist = clip.find_joint(prefix + "wrist");
        for (const RestJoint& joint : hand_joints)
            add(prefix + joint.name, joint.parent < 0 ? wrist : first + joint.parent,
                {side * joint.x, joint.y, joint.z});
    }
    const int num_joints = clip.num_joints();
    clip.zero_pose_positions = Points::Zero(num_joints, 3);
    for (int j = 1; j < num_joints; ++j) {
        const bool is_body = j < num_body_joints;
        // SMPL-X has jaw and eyes before the hands, SMPL no fingers.
        const Eigen::Index row = is_body ? j : model.rows() - 2 * num_hand_joints + j - num_body_joints;
        const bool known = model.rows() > 0 && (is_body || model.rows() >= num_body_joints + 2 * num_hand_joints);
        clip.zero_pose_positions.row(j) = known ? Eigen::RowVector3d(model.row(row) - model.row(0))
                                                : clip.zero_pose_positions.row(clip.parents[j]) + offsets[j];
    }
    clip.zero_pose_tips = Points::Zero(num_joints, 3);
    std::vector<int> num_children(num_joints, 0);
    for (int j = 1; j < num_joints; ++j) {
        clip.zero_pose_tips.row(clip.parents[j]) += clip.zero_pose_positions.row(j);
        ++num_children[clip.parents[j]];
    }
    for (int j = 0; j < num_joints; ++j) {
        if (num_children[j] > 0)
            clip.zero_pose_tips.row(j) /= num_children[j];
        else
            clip.zero_pose_tips.row(j) = clip.zero_pose_positions.row(j) + end_bone(clip.joint_names[j]);
    }
    // A hand points along its middle finger.
    for (const std::string side : {"left_", "right_"}) {
        if (!with_hands) break;
        clip.zero_pose_tips.row(clip.find_joint(side + "wrist")) =
            clip.zero_pose_positions.row(clip.find_joint(side + "middle1"));
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

using Table = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Eigen::Map<const Table> table(const NpyArray& array)
{
    return {array.values.data(), array.shape[0], array.shape[1]};
}

/// Frames x 66 axis-angles of the root and the 21 body joints, or x 156 with those of the hands.
Table read_axis_angles(const NpzFile& file)
{
    constexpr int body_columns = 3 * num_body_joints;
    if (file.has("root_orient")) {
        const NpyArray root = read_table(file, "root_orient", -1, {3});
        const NpyArray body = read_table(file, "pose_body", root.shape[0], {body_values});
        const bool with_hands = file.has("pose_hand");
        Table angles(root.shape[0], body_columns + (with_hands ? hand_values : 0));
        angles.leftCols<3>() = table(root);
        angles.middleCols<body_values>(3) = table(body);
        if (with_hands)
            angles.rightCols<hand_values>() = table(read_table(file, "pose_hand", root.shape[0], {hand_values}));
        return angles;
    }
    // SMPL has 24 joints, SMPL-H 52, SMPL-X 55; all begin with the same 22, the latter end with the hands.
    constexpr int smpl_columns = 3 * 24, smplh_columns = body_columns + hand_values;
    const NpyArray poses = read_table(file, "poses", -1, {smpl_columns, smplh_columns, smplh_columns + 9});
    if (poses.shape[1] == smpl_columns) return table(poses).leftCols<body_columns>();
    Table angles(poses.shape[0], smplh_columns);
    angles << table(poses).leftCols<body_columns>(), table(poses).rightCols<hand_values>();
    return angles;
}

/// Shape coefficients; none where the file has none.
std::vector<double> read_betas(const NpzFile& file)
{
    if (!file.has("betas")) return {};
    const NpyArray betas = file.read("betas");
    const bool one_shape = betas.shape.size() == 1 || (betas.shape.size() == 2 && betas.shape[0] == 1);
    require_input(one_shape, "{}: \"betas\" has the shape ({}), one row is needed", file.path(),
                  fmt::join(betas.shape, ", "));
    return betas.values;
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
                                    const std::string& joint)
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

MotionClip read_amass(const std::string& path, const SmplSkeleton* model)
{
    const NpzFile file(path);
    const Table angles = read_axis_angles(file);
    const NpyArray trans = read_table(file, "trans", angles.rows(), {3});

    MotionClip clip;
    clip.name = file_stem(path);
    clip.frame_rate = read_frame_rate(file);
    clip.metres_per_unit = 1.0;
    clip.axes_known = true;
    const Points joints = model == nullptr ? Points() : model->joints(read_betas(file));
    set_skeleton(clip, angles.cols() > 3 * num_body_joints, joints);
    Eigen::Vector3d root_from_origin = Eigen::Vector3d::Zero();
    if (model != nullptr) root_from_origin = joints.row(0).transpose();
    Eigen::Matrix3d ours_from_file;  // z up to y up
    ours_from_file << 1, 0, 0, 0, 0, 1, 0, -1, 0;
    clip.root_positions.resize(angles.rows(), 3);
    for (Eigen::Index f = 0; f < angles.rows(); ++f) {
        const Eigen::Vector3d root = Eigen::Map<const Eigen::Vector3d>(trans.values.data() + 3 * f) + root_from_origin;
        clip.root_positions.row(f) = (ours_from_file * root).transpose();
        std::vector<Eigen::Matrix3d> world;
        for (int j = 0; j < clip.num_joints(); ++j) {
            const Eigen::Matrix3d local =
                axis_angle_rotation(angles.row(f).segment<3>(3 * j).transpose(), path, f, clip.joint_names[j]);
            const int parent = clip.parents[j];
            // The root's rotation takes the model, which stands y up, into the file's world.
            world.push_back((parent < 0 ? ours_from_file : world[parent]) * local);
        }
        clip.world_from_joint.push_back(std::move(world));
    }
    return clip;
}

}  // namespace ndg
