// SPDX-License-Identifier: Apache-2.0
// A body of plausible proportions in an A pose, joints only, and what tests of its motion share.
#pragma once

#include "ndg/body/skeleton.h"

#include <cmath>
#include <map>
#include <string>

namespace ndg::test {

constexpr double degree = M_PI / 180.0;

/// A file or folder of the project's configs.
inline std::string config_path(const std::string& name)
{
    return std::string(NDG_TEST_SOURCE) + "/configs/" + name;
}

inline Points human_joints()
{
    std::map<std::string, Eigen::RowVector3d> at = {
        {"pelvis", {0, 0.95, 0}},     {"spine_1", {0, 1.0, -0.01}},     {"spine_2", {0, 1.08, 0}},
        {"spine_3", {0, 1.16, 0.01}}, {"spine_4", {0, 1.24, 0}},        {"spine_5", {0, 1.33, -0.02}},
        {"neck_1", {0, 1.45, -0.02}}, {"neck_2", {0, 1.5, -0.01}},      {"head", {0, 1.56, 0}},
        {"jaw", {0, 1.57, 0.02}},     {"left_eye", {0.03, 1.64, 0.08}}, {"right_eye", {-0.03, 1.64, 0.08}}};
    for (const double side : {1.0, -1.0}) {
        const std::string s = side > 0 ? "left_" : "right_";
        const auto point = [side](double x, double y, double z) { return Eigen::RowVector3d(side * x, y, z); };
        at[s + "clavicle"] = point(0.02, 1.42, 0.03);
        at[s + "upper_arm"] = point(0.17, 1.40, -0.02);
        at[s + "forearm"] = point(0.36, 1.20, -0.04);
        at[s + "forearm_twist"] = point(0.44, 1.115, -0.015);
        at[s + "hand"] = point(0.52, 1.03, 0.01);
        const char* fingers[] = {"thumb", "index", "middle", "ring", "pinky"};
        for (int f = 0; f < 5; ++f) {
            for (int k = 1; k <= 3; ++k) {
                at[s + fingers[f] + "_" + std::to_string(k)] = point(0.56 + 0.02 * k, 0.97 - 0.02 * k, 0.05 - 0.02 * f);
            }
        }
        at[s + "thigh"] = point(0.09, 0.90, 0.01);
        at[s + "shin"] = point(0.11, 0.50, 0.02);
        at[s + "foot"] = point(0.12, 0.08, -0.02);
        at[s + "toes"] = point(0.14, 0.02, 0.11);
    }
    const Skeleton& skeleton = standard_skeleton();
    Points joints(skeleton.num_joints(), 3);
    for (int j = 0; j < skeleton.num_joints(); ++j) joints.row(j) = at.at(skeleton.joint_names[j]);
    return joints;
}

/// Posed joint positions.
inline Points posed_joints(const Points& joints, const Pose& pose)
{
    const auto motions = forward_kinematics(standard_skeleton(), joints, pose);
    Points posed(joints.rows(), 3);
    for (Eigen::Index j = 0; j < joints.rows(); ++j) {
        posed.row(j) = (motions[j] * joints.row(j).transpose().eval()).transpose();
    }
    return posed;
}

inline Eigen::Vector3d at(const Points& joints, const std::string& name)
{
    return joints.row(standard_skeleton().joint(name)).transpose();
}

/// Unit vector from one joint to another.
inline Eigen::Vector3d direction(const Points& joints, const std::string& from, const std::string& to)
{
    return (at(joints, to) - at(joints, from)).normalized();
}

}  // namespace ndg::test
