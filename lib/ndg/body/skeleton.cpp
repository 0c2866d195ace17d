// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/skeleton.h"

#include "ndg/core/error.h"

#include <algorithm>

namespace ndg {

namespace {

/// Adds joints one after the other, each under a joint named before it.
class SkeletonBuilder {
public:
    void add(const std::string& name, const std::string& parent)
    {
        skeleton_.parents.push_back(parent.empty() ? -1 : skeleton_.joint(parent));
        skeleton_.joint_names.push_back(name);
    }
    /// `name`_1..count, each under the one before it.
    void add_chain(const std::string& name, int count, const std::string& parent)
    {
        for (int i = 1; i <= count; ++i) {
            add(name + "_" + std::to_string(i), i == 1 ? parent : name + "_" + std::to_string(i - 1));
        }
    }
    void add_side(const std::string& side)
    {
        add(side + "_clavicle", "spine_5");
        add(side + "_upper_arm", side + "_clavicle");
        add(side + "_forearm", side + "_upper_arm");
        add(side + "_forearm_twist", side + "_forearm");
        add(side + "_hand", side + "_forearm_twist");
        for (const char* finger : {"_thumb", "_index", "_middle", "_ring", "_pinky"}) {
            add_chain(side + finger, 3, side + "_hand");
        }
        add(side + "_thigh", "pelvis");
        add(side + "_shin", side + "_thigh");
        add(side + "_foot", side + "_shin");
        add(side + "_toes", side + "_foot");
    }
    Skeleton take() { return std::move(skeleton_); }

private:
    Skeleton skeleton_;
};

Skeleton make_standard_skeleton()
{
    SkeletonBuilder builder;
    builder.add("pelvis", "");
    builder.add_chain("spine", 5, "pelvis");
    builder.add_chain("neck", 2, "spine_5");
    builder.add("head", "neck_2");
    builder.add("jaw", "head");
    builder.add("left_eye", "head");
    builder.add("right_eye", "head");
    builder.add_side("left");
    builder.add_side("right");
    Skeleton skeleton = builder.take();
    require(skeleton.num_joints() == num_standard_joints, "The standard skeleton has {} joints instead of {}",
            skeleton.num_joints(), num_standard_joints);
    return skeleton;
}

}  // namespace

int Skeleton::joint(const std::string& name) const
{
    const auto found = std::find(joint_names.begin(), joint_names.end(), name);
    require(found != joint_names.end(), "The skeleton has no joint \"{}\"", name);
    return static_cast<int>(found - joint_names.begin());
}

const Skeleton& standard_skeleton()
{
    static const Skeleton skeleton = make_standard_skeleton();
    return skeleton;
}

Pose Pose::rest(int num_joints)
{
    Pose pose;
    pose.parent_from_joint.assign(num_joints, Eigen::Matrix3d::Identity());
    return pose;
}

std::vector<Eigen::Isometry3d> forward_kinematics(const Skeleton& skeleton,
                                                  const Eigen::Ref<const Points>& joint_positions, const Pose& pose)
{
    const auto num_joints = static_cast<std::size_t>(skeleton.num_joints());
    require(
        static_cast<std::size_t>(joint_positions.rows()) == num_joints && pose.parent_from_joint.size() == num_joints,
        "A skeleton of {} joints was given {} joint positions and {} joint rotations", num_joints,
        joint_positions.rows(), pose.parent_from_joint.size());

    std::vector<Eigen::Isometry3d> world_from_rest(num_joints, Eigen::Isometry3d::Identity());
    for (std::size_t j = 0; j < num_joints; ++j) {
        const Eigen::Vector3d rest_position = joint_positions.row(static_cast<Eigen::Index>(j)).transpose();
        const int parent = skeleton.parents[j];
        Eigen::Matrix3d world_from_joint = pose.parent_from_joint[j];
        Eigen::Vector3d posed_position = rest_position + pose.root_translation;
        if (parent >= 0) {
            const Eigen::Isometry3d& parent_motion = world_from_rest[parent];
            // At rest all joint frames are world-aligned, so the parent's motion is its frame's rotation.
            world_from_joint = parent_motion.linear() * pose.parent_from_joint[j];
            posed_position = parent_motion * rest_position;
        }
        world_from_rest[j].linear() = world_from_joint;
        world_from_rest[j].translation() = posed_position - world_from_joint * rest_position;
    }
    return world_from_rest;
}

}  // namespace ndg
