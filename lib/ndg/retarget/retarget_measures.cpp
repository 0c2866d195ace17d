// SPDX-License-Identifier: Apache-2.0
#include "ndg/retarget/retarget_measures.h"

#include "ndg/geometry/rotation.h"

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

Points posed_joints(const Points& rest, const std::vector<Eigen::Matrix3d>& parent_from_joint)
{
    const Skeleton& skeleton = standard_skeleton();
    const std::vector<Eigen::Matrix3d> world = compose_rotations(parent_from_joint);
    Points ours = Points::Zero(rest.rows(), 3);
    for (int j = 1; j < skeleton.num_joints(); ++j) {
        const int parent = skeleton.parents[j];
        ours.row(j) = ours.row(parent) + (rest.row(j) - rest.row(parent)) * world[parent].transpose();
    }
    return ours;
}

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b)
{
    return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// From the middle of two rows to that of two others.
Eigen::Vector3d between(const Points& points, const std::array<int, 2>& from, const std::array<int, 2>& to)
{
    return 0.5 * (points.row(to[0]) + points.row(to[1]) - points.row(from[0]) - points.row(from[1])).transpose();
}

}  // namespace

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
    const Points ours = posed_joints(rest, parent_from_joint);
    const Points source = transfer.clip().joint_positions(frame_idx);
    double sum = 0.0;
    int count = 0;
    for (std::size_t j = 0; j < transfer.links().size(); ++j) {
        const RotationTransfer::Link& link = transfer.links()[j];
        if (!link.aligned() || link.sole || link.bone_to < 0) continue;
        const Eigen::Vector3d a = (ours.row(link.toward) - ours.row(static_cast<Eigen::Index>(j))).transpose();
        const Eigen::Vector3d b = (source.row(link.bone_to) - source.row(link.bone_from)).transpose();
        sum += angle_between(a, b);
        ++count;
    }
    return count > 0 ? sum / count : 0.0;
}

SegmentDirections::SegmentDirections(const RotationTransfer& transfer) : transfer_(transfer)
{
    const Skeleton& skeleton = standard_skeleton();
    const auto& links = transfer.links();
    const auto add = [&](const std::string& name, const std::array<std::string, 2>& from,
                         const std::array<std::string, 2>& to) {
        Segment segment;
        segment.name = name;
        for (std::size_t k = 0; k < 2; ++k) {
            segment.from[k] = skeleton.joint(from[k]);
            segment.to[k] = skeleton.joint(to[k]);
            for (const int joint : {segment.from[k], segment.to[k]}) {
                if (links[joint].source < 0 || links[joint].blend_with >= 0) return;
            }
        }
        segments_.push_back(segment);
    };
    add("trunk", {"left_thigh", "right_thigh"}, {"left_upper_arm", "right_upper_arm"});
    add("hips", {"right_thigh", "right_thigh"}, {"left_thigh", "left_thigh"});
    add("shoulders", {"right_upper_arm", "right_upper_arm"}, {"left_upper_arm", "left_upper_arm"});
    const std::array<std::array<const char*, 3>, 5> limbs = {{{"upper_arm", "upper_arm", "forearm"},
                                                              {"forearm", "forearm", "hand"},
                                                              {"thigh", "thigh", "shin"},
                                                              {"shin", "shin", "foot"},
                                                              {"foot", "foot", "toes"}}};
    for (const std::string side : {"left_", "right_"}) {
        for (const auto& [name, from, to] : limbs) add(side + name, {side + from, side + from}, {side + to, side + to});
    }
}

void SegmentDirections::add(const Points& rest, const std::vector<Eigen::Matrix3d>& parent_from_joint, int frame_idx)
{
    const Points ours = posed_joints(rest, parent_from_joint), source = transfer_.clip().joint_positions(frame_idx);
    const auto& links = transfer_.links();
    ++num_frames_;
    for (Segment& segment : segments_) {
        const std::array<int, 2> from = {links[segment.from[0]].source, links[segment.from[1]].source};
        const std::array<int, 2> to = {links[segment.to[0]].source, links[segment.to[1]].source};
        const double angle = angle_between(between(ours, segment.from, segment.to), between(source, from, to));
        segment.sum += angle;
        segment.max = std::max(segment.max, angle);
    }
}

std::vector<SegmentError> SegmentDirections::errors() const
{
    std::vector<SegmentError> errors;
    if (num_frames_ == 0) return errors;
    for (const Segment& segment : segments_) errors.push_back({segment.name, segment.sum / num_frames_, segment.max});
    return errors;
}

}  // namespace ndg
