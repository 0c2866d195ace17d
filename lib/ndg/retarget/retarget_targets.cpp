// SPDX-License-Identifier: Apache-2.0
#include "ndg/retarget/retarget_targets.h"

#include "ndg/geometry/rotation.h"

#include <algorithm>

namespace ndg {

namespace {

/// Shortest segment of a source that has a direction, as a share of its legs.
constexpr double shortest_share = 0.005;

bool is_above(const MotionClip& clip, int ancestor, int joint)
{
    for (int j = clip.parents[joint]; j >= 0; j = clip.parents[j]) {
        if (j == ancestor) return true;
    }
    return false;
}

bool is_landmark(const RotationTransfer& transfer, int joint)
{
    const Skeleton& skeleton = standard_skeleton();
    const auto& links = transfer.links();
    if (skeleton.parents[joint] < 0 || links[joint].source < 0 || links[joint].blend_with >= 0) return false;
    for (int j = skeleton.parents[joint]; j >= 0; j = skeleton.parents[j]) {
        if (links[j].source < 0) continue;
        if (!is_above(transfer.clip(), links[j].source, links[joint].source)) return false;
        // A twist moves nothing on its axis.
        if (links[j].blend_with < 0 || links[j].twist_only) continue;
        if (!is_above(transfer.clip(), links[j].blend_with, links[joint].source)) return false;
    }
    return true;
}

/// Nearest joint above that the map moves; the root always.
int carrier_of(const RotationTransfer& transfer, int joint)
{
    int above = standard_skeleton().parents[joint];
    while (above > 0 && transfer.links()[above].source < 0) above = standard_skeleton().parents[above];
    return above;
}

}  // namespace

Eigen::Vector3d ScaledTargets::Segment::apply(const Eigen::Matrix3d& turned, const Eigen::Vector3d& source) const
{
    if (!has_length) return turned * ours;
    return factor * (turned * redirection * turned.transpose() * source);
}

ScaledTargets::Segment ScaledTargets::segment(const Eigen::Vector3d& source, const Eigen::Vector3d& ours) const
{
    Segment result;
    result.ours = ours;
    result.has_length = source.norm() > shortest_share * transfer_.source_leg_length();
    if (!result.has_length) return result;
    result.factor = ours.norm() / source.norm();
    if (ours.norm() > 0) result.redirection = minimal_rotation(source, ours);
    return result;
}

Eigen::Vector3d ScaledTargets::source_centre(const Cluster& cluster, const Points& source_positions) const
{
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const Member& member : cluster.members) {
        centre += source_positions.row(transfer_.links()[landmarks_[member.landmark_idx]].source).transpose();
    }
    return centre / static_cast<double>(cluster.members.size());
}

Eigen::Vector3d ScaledTargets::source_base(const Cluster& cluster, const Points& source_positions) const
{
    if (cluster.from_hips()) return transfer_.source_hips(source_positions);
    return source_positions.row(transfer_.links()[cluster.base].source).transpose();
}

Eigen::Vector3d ScaledTargets::our_base(const Cluster& cluster, const Points& aligned) const
{
    if (cluster.from_hips()) return transfer_.alignment()[0] * transfer_.hips_from_root();
    return aligned.row(cluster.base).transpose();
}

ScaledTargets::ScaledTargets(const RotationTransfer& transfer, const Eigen::Ref<const Points>& joint_positions)
    : transfer_(transfer)
{
    const Skeleton& skeleton = standard_skeleton();
    for (int j = 0; j < skeleton.num_joints(); ++j) {
        if (is_landmark(transfer, j)) landmarks_.push_back(j);
    }

    // Our joints with the rest poses aligned.
    Points aligned = Points::Zero(skeleton.num_joints(), 3);
    for (int j = 1; j < skeleton.num_joints(); ++j) {
        const int parent = skeleton.parents[j];
        const Eigen::Vector3d bone = (joint_positions.row(j) - joint_positions.row(parent)).transpose();
        aligned.row(j) = aligned.row(parent) + (transfer.alignment()[parent] * bone).transpose();
    }

    for (std::size_t k = 0; k < landmarks_.size(); ++k) {
        const int joint = landmarks_[k];
        int base = skeleton.parents[joint];
        auto found = landmarks_.end();
        while (base > 0 && (found = std::find(landmarks_.begin(), landmarks_.end(), base)) == landmarks_.end()) {
            base = skeleton.parents[base];
        }
        const int carrier = carrier_of(transfer, joint);
        const auto same = [&](const Cluster& c) { return c.base == base && c.carrier == carrier && base != carrier; };
        auto cluster = std::find_if(clusters_.begin(), clusters_.end(), same);
        if (cluster == clusters_.end()) {
            cluster = clusters_.insert(clusters_.end(), Cluster());
            cluster->base = base;
            cluster->carrier = carrier;
            if (base > 0) cluster->base_landmark_idx = static_cast<int>(found - landmarks_.begin());
        }
        cluster->members.push_back({static_cast<int>(k), {}});
    }
    const Points& zero_pose = transfer.clip().zero_pose_positions;
    for (Cluster& cluster : clusters_) {
        Eigen::Vector3d ours = Eigen::Vector3d::Zero();
        for (const Member& member : cluster.members) ours += aligned.row(landmarks_[member.landmark_idx]).transpose();
        ours /= static_cast<double>(cluster.members.size());
        const Eigen::Vector3d source = source_centre(cluster, zero_pose);
        cluster.to_centre = segment(source - source_base(cluster, zero_pose), ours - our_base(cluster, aligned));
        for (Member& member : cluster.members) {
            const int joint = landmarks_[member.landmark_idx];
            member.from_centre = segment(zero_pose.row(transfer.links()[joint].source).transpose() - source,
                                         aligned.row(joint).transpose() - ours);
        }
    }
}

Points ScaledTargets::targets(int frame_idx) const
{
    const Points source = transfer_.clip().joint_positions(frame_idx);
    Points result(static_cast<Eigen::Index>(landmarks_.size()), 3);
    // A cluster's base is above its members, so it is placed before them: landmarks ascend.
    for (const Cluster& cluster : clusters_) {
        const Eigen::Matrix3d base = transfer_.source_rotation(cluster.base, frame_idx);
        const Eigen::Matrix3d carrier = transfer_.source_rotation(cluster.carrier, frame_idx);
        Eigen::Vector3d centre = Eigen::Vector3d::Zero();
        if (cluster.base_landmark_idx >= 0) centre = result.row(cluster.base_landmark_idx).transpose();
        if (cluster.from_hips()) centre = base * transfer_.alignment()[0] * transfer_.hips_from_root();
        const Eigen::Vector3d source_middle = source_centre(cluster, source);
        const Eigen::Matrix3d between = to_quaternion(base).slerp(0.5, to_quaternion(carrier)).toRotationMatrix();
        centre += cluster.to_centre.apply(between, source_middle - source_base(cluster, source));
        for (const Member& member : cluster.members) {
            const int source_joint = transfer_.links()[landmarks_[member.landmark_idx]].source;
            const Eigen::Vector3d offset =
                member.from_centre.apply(carrier, source.row(source_joint).transpose() - source_middle);
            result.row(member.landmark_idx) = (centre + offset).transpose();
        }
    }
    return result;
}

Points ScaledTargets::uniform_targets(int frame_idx, const Eigen::Matrix3d& pelvis) const
{
    const Points source = transfer_.clip().joint_positions(frame_idx);
    const Eigen::Vector3d shift =
        pelvis * transfer_.hips_from_root() - transfer_.scale() * transfer_.source_hips(source);
    Points result(static_cast<Eigen::Index>(landmarks_.size()), 3);
    for (std::size_t k = 0; k < landmarks_.size(); ++k) {
        result.row(static_cast<Eigen::Index>(k)) =
            transfer_.scale() * source.row(transfer_.links()[landmarks_[k]].source) + shift.transpose();
    }
    return result;
}

}  // namespace ndg
