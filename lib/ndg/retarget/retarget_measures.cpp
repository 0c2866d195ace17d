// SPDX-License-Identifier: Apache-2.0
#include "ndg/retarget/retarget_measures.h"

#include "ndg/geometry/rotation.h"

#include <cmath>

namespace ndg {

double relative_jump(const MotionClip& clip, int frame_idx, int a, int b)
{
    const auto relative = [&](int f) {
        const Eigen::Matrix3d& second = clip.world_from_joint[f][b];
        return a < 0 ? second : Eigen::Matrix3d(clip.world_from_joint[f][a].transpose() * second);
    };
    return rotation_angle(relative(frame_idx - 1), relative(frame_idx));
}

double direction_error(const RotationTransfer& transfer, const Points& rest,
                       const std::vector<Eigen::Matrix3d>& parent_from_joint, int frame_idx)
{
    const Skeleton& skeleton = standard_skeleton();
    const std::vector<Eigen::Matrix3d> world = compose_rotations(parent_from_joint);
    Points ours = Points::Zero(rest.rows(), 3);
    for (int j = 1; j < skeleton.num_joints(); ++j) {
        const int parent = skeleton.parents[j];
        ours.row(j) = ours.row(parent) + (rest.row(j) - rest.row(parent)) * world[parent].transpose();
    }
    const Points source = transfer.clip().joint_positions(frame_idx);
    double sum = 0.0;
    int count = 0;
    for (std::size_t j = 0; j < world.size(); ++j) {
        const RotationTransfer::Link& link = transfer.links()[j];
        if (!link.aligned() || link.sole || link.bone_to < 0) continue;
        const Eigen::Vector3d a = (ours.row(link.toward) - ours.row(static_cast<Eigen::Index>(j))).transpose();
        const Eigen::Vector3d b = (source.row(link.bone_to) - source.row(link.bone_from)).transpose();
        sum += std::atan2(a.cross(b).norm(), a.dot(b));
        ++count;
    }
    return count > 0 ? sum / count : 0.0;
}

}  // namespace ndg
