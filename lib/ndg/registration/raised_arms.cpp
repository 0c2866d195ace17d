// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/raised_arms.h"

#include <algorithm>
#include <string>

namespace ndg {
namespace {

/// How far up an arm's turn goes between 25 and 50 degrees, 0 to 1.
double turned_far(const Eigen::Matrix3d& parent_from_joint)
{
    constexpr double low = 25.0 * EIGEN_PI / 180.0, high = 2.0 * low;
    return std::clamp((Eigen::AngleAxisd(parent_from_joint).angle() - low) / (high - low), 0.0, 1.0);
}

}  // namespace

bool raised_arms(const Pose& pose)
{
    const Skeleton& skeleton = standard_skeleton();
    return turned_far(pose.parent_from_joint[skeleton.joint("left_upper_arm")]) > 0.5 ||
           turned_far(pose.parent_from_joint[skeleton.joint("right_upper_arm")]) > 0.5;
}

void keep_raised_arms(const Pose& pose, const Points& likeliest, Points& joints)
{
    if (!raised_arms(pose)) return;
    const Skeleton& skeleton = standard_skeleton();
    const Eigen::RowVector3d shift = (joints.row(skeleton.joint("spine_5")) - likeliest.row(skeleton.joint("spine_5")));
    for (const std::string side : {"left_", "right_"}) {
        for (int j = skeleton.joint(side + "clavicle"); j < skeleton.num_joints(); ++j) {
            int parent = j;
            while (parent > skeleton.joint(side + "clavicle")) parent = skeleton.parents[parent];
            if (parent == skeleton.joint(side + "clavicle")) joints.row(j) = likeliest.row(j) + shift;
        }
    }
}

Eigen::VectorXd unposed_confidence(const SkinnedSurface& skin, const Pose& pose)
{
    Eigen::VectorXd confidence = Eigen::VectorXd::Ones(skin.vertices.rows());
    for (const std::string side : {"left_", "right_"}) {
        const int joint = standard_skeleton().joint(side + "upper_arm");
        const double far = turned_far(pose.parent_from_joint[joint]);
        if (far <= 0) continue;
        const Eigen::VectorXd arm = subtree_weights(skin.weights, {side + "upper_arm"});
        const Eigen::VectorXd girdle = subtree_weights(skin.weights, {side + "clavicle"});
        const double reach = 0.5 * (skin.joint_positions.row(joint) -
                                    skin.joint_positions.row(standard_skeleton().joint(side + "forearm")))
                                       .norm();
        for (Eigen::Index v = 0; v < confidence.size(); ++v) {
            const double mixed = std::max(arm[v] * (1.0 - arm[v]), girdle[v] * (1.0 - girdle[v]));
            const double near = (skin.vertices.row(v) - skin.joint_positions.row(joint)).norm() / reach;
            const double doubt = std::max(std::clamp(8.0 * mixed, 0.0, 1.0), std::clamp(2.0 - 2.0 * near, 0.0, 1.0));
            if (near < 1.5) confidence[v] = std::min(confidence[v], 1.0 - far * doubt);
        }
    }
    return confidence;
}

}  // namespace ndg
