// SPDX-License-Identifier: Apache-2.0
// Rigs of other people, made from motions of our own: the same world positions in every frame, other frames of joints.
#pragma once

#include "ndg/geometry/rotation.h"
#include "ndg/io/motion.h"
#include "ndg/motion/keyframes.h"

#include "motion/human.h"

#include <Eigen/Geometry>

#include <cmath>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

namespace ndg::test {

struct RigJoint {
    std::string name, parent, ours;
};

/// Mixamo's joints without prefix and fingers.
inline std::vector<RigJoint> plain_rig()
{
    std::vector<RigJoint> rig = {{"Hips", "", "pelvis"},         {"Spine", "Hips", "spine_2"},
                                 {"Spine1", "Spine", "spine_3"}, {"Spine2", "Spine1", "spine_5"},
                                 {"Neck", "Spine2", "neck_1"},   {"Head", "Neck", "head"}};
    for (const std::string side : {"Left", "Right"}) {
        const std::string ours = side == "Left" ? "left_" : "right_";
        rig.push_back({side + "Shoulder", "Spine2", ours + "clavicle"});
        rig.push_back({side + "Arm", side + "Shoulder", ours + "upper_arm"});
        rig.push_back({side + "ForeArm", side + "Arm", ours + "forearm"});
        rig.push_back({side + "Hand", side + "ForeArm", ours + "hand"});
        rig.push_back({side + "UpLeg", "Hips", ours + "thigh"});
        rig.push_back({side + "Leg", side + "UpLeg", ours + "shin"});
        rig.push_back({side + "Foot", side + "Leg", ours + "foot"});
        rig.push_back({side + "ToeBase", side + "Foot", ours + "toes"});
    }
    return rig;
}

inline std::vector<RigJoint> renamed(std::vector<RigJoint> rig,
                                     const std::function<std::string(const std::string&)>& name)
{
    for (RigJoint& joint : rig) {
        joint.name = name(joint.name);
        if (!joint.parent.empty()) joint.parent = name(joint.parent);
    }
    return rig;
}

/// A motion of our own on a rig whose zero pose is our rest pose, centimetres.
inline MotionClip clip_of(const PoseSet& poses, const std::vector<RigJoint>& rig)
{
    const Points joints = human_joints();
    const Skeleton& skeleton = standard_skeleton();
    MotionClip clip;
    clip.name = "own";
    clip.frame_rate = poses.clip_frame_rates.front();
    const auto count = static_cast<Eigen::Index>(rig.size());
    clip.zero_pose_positions.resize(count, 3);
    for (Eigen::Index j = 0; j < count; ++j) {
        clip.joint_names.push_back(rig[std::size_t(j)].name);
        clip.parents.push_back(rig[std::size_t(j)].parent.empty() ? -1 : clip.find_joint(rig[std::size_t(j)].parent));
        clip.zero_pose_positions.row(j) = 100.0 * joints.row(skeleton.joint(rig[std::size_t(j)].ours));
    }
    clip.zero_pose_positions.rowwise() -= clip.zero_pose_positions.row(0).eval();
    // Leaves go on as the bone before them, hands and toes for 8 cm, the head upwards.
    clip.zero_pose_tips = clip.zero_pose_positions;
    for (Eigen::Index j = 1; j < count; ++j) {
        const int parent = clip.parents[std::size_t(j)];
        const Eigen::RowVector3d bone = clip.zero_pose_positions.row(j) - clip.zero_pose_positions.row(parent);
        clip.zero_pose_tips.row(j) += 8.0 * bone.normalized();
        clip.zero_pose_tips.row(parent) = clip.zero_pose_positions.row(j);
    }
    for (const Pose& pose : poses.poses) {
        const auto motions = forward_kinematics(skeleton, joints, pose);
        std::vector<Eigen::Matrix3d> world;
        for (const RigJoint& joint : rig) world.emplace_back(motions[std::size_t(skeleton.joint(joint.ours))].linear());
        clip.world_from_joint.push_back(world);
        clip.root_positions.conservativeResize(clip.num_frames(), 3);
        clip.root_positions.row(clip.num_frames() - 1) =
            100.0 * (motions[0] * joints.row(0).transpose().eval()).transpose();
    }
    return clip;
}

inline MotionClip built_in_clip(const std::string& name, const std::vector<RigJoint>& rig, double frame_rate = 0.0)
{
    const KeyframeMotion motion = read_keyframe_motion(config_path("motions/" + name + ".json"));
    return clip_of(keyframe_poses(motion, human_joints(), frame_rate), rig);
}

/// Rotations about x, y and z in degrees, in the order "Zrotation Yrotation Xrotation" of a BVH.
inline Eigen::Vector3d zyx_degrees(const Eigen::Matrix3d& rotation)
{
    const double y = std::asin(std::max(-1.0, std::min(1.0, -rotation(2, 0))));
    double z = std::atan2(rotation(1, 0), rotation(0, 0)), x = std::atan2(rotation(2, 1), rotation(2, 2));
    if (std::abs(rotation(2, 0)) > 1.0 - 1e-12) {
        z = 0.0;
        x = std::atan2(-rotation(1, 2), rotation(1, 1));
    }
    return Eigen::Vector3d(x, y, z) / degree;
}

/// The clip as BVH in which joint j has the frame `frames[j]` of the clip's zero pose as its own: the zero pose of the
/// file is the one in which all these frames lie along the world's axes, positions in frames are the clip's.
inline void write_bvh(const std::string& path, const MotionClip& clip, const std::vector<Eigen::Matrix3d>& frames,
                      double frame_time = 0.0)
{
    std::ofstream file(path);
    file.precision(10);
    const auto offset = [&](int j, const Eigen::RowVector3d& bone) {
        const Eigen::Vector3d local = frames[std::size_t(j)].transpose() * bone.transpose();
        file << "OFFSET " << local.x() << " " << local.y() << " " << local.z() << "\n";
    };
    std::vector<int> order;
    const std::function<void(int)> write_joint = [&](int j) {
        const int parent = clip.parents[std::size_t(j)];
        order.push_back(j);
        file << (parent < 0 ? "ROOT " : "JOINT ") << clip.joint_names[std::size_t(j)] << "\n{\n";
        if (parent < 0) {
            file << "OFFSET 0 0 0\nCHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation\n";
        } else {
            offset(parent, clip.zero_pose_positions.row(j) - clip.zero_pose_positions.row(parent));
            file << "CHANNELS 3 Zrotation Yrotation Xrotation\n";
        }
        bool leaf = true;
        for (int child = j + 1; child < clip.num_joints(); ++child) {
            if (clip.parents[std::size_t(child)] != j) continue;
            leaf = false;
            write_joint(child);
        }
        if (leaf) {
            file << "End Site\n{\n";
            offset(j, clip.zero_pose_tips.row(j) - clip.zero_pose_positions.row(j));
            file << "}\n";
        }
        file << "}\n";
    };
    file << "HIERARCHY\n";
    write_joint(0);
    file << "MOTION\nFrames: " << clip.num_frames()
         << "\nFrame Time: " << (frame_time > 0.0 ? frame_time : 1.0 / clip.frame_rate) << "\n";
    for (int f = 0; f < clip.num_frames(); ++f) {
        const auto world = [&](int j) {
            return Eigen::Matrix3d(clip.world_from_joint[std::size_t(f)][std::size_t(j)] * frames[std::size_t(j)]);
        };
        file << clip.root_positions.row(f);
        for (const int j : order) {
            const int parent = clip.parents[std::size_t(j)];
            const Eigen::Vector3d angles =
                zyx_degrees(parent < 0 ? world(j) : Eigen::Matrix3d(world(parent).transpose() * world(j)));
            file << " " << angles.z() << " " << angles.y() << " " << angles.x();
        }
        file << "\n";
    }
}

using Frames = std::vector<Eigen::Matrix3d>;

inline Frames own_frames(const MotionClip& clip)
{
    return Frames(std::size_t(clip.num_joints()), Eigen::Matrix3d::Identity());
}

/// Frames whose x axis lies along each joint's bone (the left side's against it).
inline Frames frames_along_x(const MotionClip& clip)
{
    Frames frames;
    for (int j = 0; j < clip.num_joints(); ++j) {
        Eigen::Vector3d bone = (clip.zero_pose_tips.row(j) - clip.zero_pose_positions.row(j)).transpose();
        if (clip.joint_names[std::size_t(j)].find("Left") != std::string::npos) bone = -bone;
        frames.push_back(minimal_rotation(Eigen::Vector3d::UnitX(), bone));
    }
    return frames;
}

/// Frames that make the pose with these world rotations the zero pose.
inline Frames frames_of_pose(const std::vector<Eigen::Matrix3d>& world_from_joint)
{
    Frames frames;
    for (const Eigen::Matrix3d& rotation : world_from_joint) frames.emplace_back(rotation.transpose());
    return frames;
}

/// Frames that turn the zero pose as a whole.
inline Frames frames_turned(const MotionClip& clip, const Eigen::Matrix3d& turn)
{
    return Frames(std::size_t(clip.num_joints()), turn.transpose());
}

}  // namespace ndg::test
