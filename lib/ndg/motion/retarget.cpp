// SPDX-License-Identifier: Apache-2.0
#include "ndg/motion/retarget.h"

#include "ndg/core/error.h"
#include "ndg/motion/rotation.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ndg {

namespace {

constexpr double shortest_bone = 1e-6;

/// A joint map resolved to indices of one clip.
struct Link {
    int source = -1, blend_with = -1;  ///< -1: none
    double fraction = 0.0;
    bool twist_only = false;
    Eigen::Vector3d source_bone = Eigen::Vector3d::Zero();  ///< zero pose; zero where not aligned
    Eigen::Vector3d our_bone = Eigen::Vector3d::Zero();     ///< rest pose
    double limit = 2.0 * M_PI;                              ///< rad from rest
    bool sole = false;
    Eigen::Vector3d source_up = Eigen::Vector3d::UnitY();

    bool aligned() const { return !source_bone.isZero(0.0); }
};

Eigen::Vector3d source_vector(const MotionClip& clip, const std::string& from, const std::string& to)
{
    const int a = clip.find_joint(from);
    const Eigen::RowVector3d end =
        to.empty() ? clip.zero_pose_tips.row(a) : clip.zero_pose_positions.row(clip.find_joint(to));
    return (end - clip.zero_pose_positions.row(a)).transpose();
}

/// One link a joint of ours.
std::vector<Link> resolve(const MotionClip& clip, const JointMap& map, const Eigen::Ref<const Points>& joint_positions)
{
    const std::string missing = missing_source_joint(map, clip);
    require_input(missing.empty(), "clip {}: has no joint \"{}\", which the joint map {} needs", clip.name, missing,
                  map.path);
    const Skeleton& skeleton = standard_skeleton();
    require(joint_positions.rows() == skeleton.num_joints(), "retarget: {} joint positions instead of {}",
            joint_positions.rows(), skeleton.num_joints());
    std::vector<Link> links(skeleton.joint_names.size());
    for (const JointMapEntry& entry : map.entries) {
        const int j = skeleton.joint(entry.joint);
        Link& link = links[j];
        link.source = clip.find_joint(entry.source);
        if (!entry.blend_with.empty()) link.blend_with = clip.find_joint(entry.blend_with);
        link.fraction = entry.fraction;
        link.twist_only = entry.twist_only;
        link.sole = entry.sole;
        link.limit = entry.limit;
        if (entry.toward.empty()) continue;
        link.source_bone = source_vector(clip, entry.bone_from, entry.bone_to);
        link.our_bone = (joint_positions.row(skeleton.joint(entry.toward)) - joint_positions.row(j)).transpose();
        if (!entry.up_from.empty()) link.source_up = source_vector(clip, entry.up_from, entry.up_to);
        require_input(link.source_bone.norm() > shortest_bone,
                      "clip {}: the bone of \"{}\" has zero length at the zero pose", clip.name, entry.bone_from);
        require_input(link.source_up.norm() > shortest_bone, "clip {}: the sole normal of \"{}\" is zero", clip.name,
                      entry.joint);
        require_input(link.our_bone.norm() > shortest_bone, "the body's bone from \"{}\" to \"{}\" has zero length",
                      entry.joint, entry.toward);
    }
    return links;
}

/// Right-handed frame with columns: lateral, up, heading of `bone` in the plane across `up`.
Eigen::Matrix3d sole_frame(const Eigen::Vector3d& up, const Eigen::Vector3d& bone)
{
    Eigen::Matrix3d frame;
    frame.col(1) = up.normalized();
    frame.col(2) = (bone - frame.col(1) * frame.col(1).dot(bone)).normalized();
    frame.col(0) = frame.col(1).cross(frame.col(2));
    return frame;
}

std::vector<Eigen::Matrix3d> align(const std::vector<Link>& links)
{
    const Skeleton& skeleton = standard_skeleton();
    std::vector<Eigen::Matrix3d> alignment(links.size(), Eigen::Matrix3d::Identity());
    for (std::size_t j = 0; j < links.size(); ++j) {
        const Link& link = links[j];
        if (skeleton.parents[j] >= 0) alignment[j] = alignment[skeleton.parents[j]];
        if (!link.aligned()) continue;
        if (link.sole) {
            alignment[j] = sole_frame(link.source_up, link.source_bone) *
                           sole_frame(Eigen::Vector3d::UnitY(), link.our_bone).transpose();
        } else {
            alignment[j] = minimal_rotation(alignment[j] * link.our_bone, link.source_bone) * alignment[j];
        }
    }
    return alignment;
}

Eigen::Matrix3d source_rotation(const Link& link, const std::vector<Eigen::Matrix3d>& world_from_source,
                                const Eigen::Vector3d& twist_axis)
{
    const Eigen::Matrix3d& first = world_from_source[link.source];
    if (link.blend_with < 0) return first;
    const Eigen::Matrix3d& second = world_from_source[link.blend_with];
    if (link.twist_only) {
        const double angle = twist_angle(first.transpose() * second, twist_axis);
        return first * Eigen::AngleAxisd(link.fraction * angle, twist_axis).toRotationMatrix();
    }
    return to_quaternion(first).slerp(link.fraction, to_quaternion(second)).toRotationMatrix();
}

/// Source bones that carry twist: that of the joint itself or of the nearest ancestor with an aligned bone.
std::vector<Eigen::Vector3d> twist_axes(const std::vector<Link>& links)
{
    const Skeleton& skeleton = standard_skeleton();
    std::vector<Eigen::Vector3d> axes(links.size(), Eigen::Vector3d::UnitY());
    for (std::size_t j = 0; j < links.size(); ++j) {
        if (links[j].aligned())
            axes[j] = links[j].source_bone.normalized();
        else if (skeleton.parents[j] >= 0)
            axes[j] = axes[skeleton.parents[j]];
    }
    return axes;
}

/// Where the hips' midpoint lies, and the length of hip-knee-ankle averaged over both legs.
struct Legs {
    Eigen::RowVector3d hip_centre;
    double length = 0.0;
};

Legs measure_legs(const Eigen::Ref<const Points>& positions, const std::array<int, 6>& joints)
{
    Legs legs;
    legs.hip_centre = 0.5 * (positions.row(joints[0]) + positions.row(joints[3]));
    for (int side = 0; side < 2; ++side) {
        const int* leg = joints.data() + 3 * side;
        legs.length += 0.5 * (positions.row(leg[1]) - positions.row(leg[0])).norm();
        legs.length += 0.5 * (positions.row(leg[2]) - positions.row(leg[1])).norm();
    }
    return legs;
}

std::array<int, 6> our_leg_joints()
{
    const Skeleton& skeleton = standard_skeleton();
    return {skeleton.joint("left_thigh"),  skeleton.joint("left_shin"),  skeleton.joint("left_foot"),
            skeleton.joint("right_thigh"), skeleton.joint("right_shin"), skeleton.joint("right_foot")};
}

std::vector<Eigen::Matrix3d> local_rotations(const std::vector<Eigen::Matrix3d>& world_from_joint)
{
    const Skeleton& skeleton = standard_skeleton();
    std::vector<Eigen::Matrix3d> parent_from_joint(world_from_joint.size());
    for (std::size_t j = 0; j < world_from_joint.size(); ++j) {
        const int parent = skeleton.parents[j];
        Eigen::Matrix3d local = world_from_joint[j];
        if (parent >= 0) local = world_from_joint[parent].transpose() * local;
        // Back onto the rotations: products of many matrices drift by rounding.
        parent_from_joint[j] = to_quaternion(local).toRotationMatrix();
    }
    return parent_from_joint;
}

/// All frames of a clip on our skeleton.
std::vector<Pose> transfer(const MotionClip& clip, const std::vector<Link>& links,
                           const Eigen::Ref<const Points>& joint_positions, int first_frame)
{
    const Skeleton& skeleton = standard_skeleton();
    const std::vector<Eigen::Matrix3d> alignment = align(links);
    const std::vector<Eigen::Vector3d> axes = twist_axes(links);
    const std::array<int, 6> our_legs = our_leg_joints();
    std::array<int, 6> source_legs{};
    for (std::size_t k = 0; k < 6; ++k) source_legs[k] = links[our_legs[k]].source;
    const Legs ours = measure_legs(joint_positions, our_legs);
    const Legs source = measure_legs(clip.zero_pose_positions, source_legs);
    require_input(source.length > shortest_bone, "clip {}: the legs have zero length", clip.name);
    const double scale = ours.length / source.length;

    std::vector<Pose> poses(clip.num_frames());
    Eigen::RowVector3d origin = Eigen::RowVector3d::Zero();
    std::vector<Eigen::Matrix3d> world_from_joint(links.size());
    for (int f = 0; f < clip.num_frames(); ++f) {
        for (std::size_t j = 0; j < links.size(); ++j) {
            const int parent = skeleton.parents[j];
            if (links[j].source >= 0) {
                world_from_joint[j] = source_rotation(links[j], clip.world_from_joint[f], axes[j]) * alignment[j];
            } else {
                world_from_joint[j] = parent >= 0 ? world_from_joint[parent] : Eigen::Matrix3d::Identity();
            }
        }
        poses[f].parent_from_joint = local_rotations(world_from_joint);
        const Eigen::RowVector3d centre = scale * measure_legs(clip.joint_positions(f), source_legs).hip_centre;
        if (f == first_frame) origin = Eigen::RowVector3d(centre.x(), 0.0, centre.z());
        const Eigen::RowVector3d root_rest = joint_positions.row(0);
        const Eigen::Vector3d hips_from_root = (ours.hip_centre - root_rest).transpose();
        poses[f].root_translation = (centre - root_rest).transpose() - world_from_joint[0] * hips_from_root;
    }
    for (Pose& pose : poses) pose.root_translation -= origin.transpose();
    return poses;
}

/// Angle between aligned bones of the source and ours, recomposed from the local rotations; mean over the bones.
double direction_error(const Pose& pose, const MotionClip& clip, int frame_idx, const std::vector<Link>& links)
{
    const Skeleton& skeleton = standard_skeleton();
    std::vector<Eigen::Matrix3d> world_from_joint(links.size());
    double sum = 0.0;
    int count = 0;
    for (std::size_t j = 0; j < links.size(); ++j) {
        const int parent = skeleton.parents[j];
        world_from_joint[j] = pose.parent_from_joint[j];
        if (parent >= 0) world_from_joint[j] = world_from_joint[parent] * pose.parent_from_joint[j];
        const Link& link = links[j];
        if (!link.aligned() || link.sole) continue;
        const Eigen::Vector3d a = world_from_joint[j] * link.our_bone;
        const Eigen::Vector3d b = clip.world_from_joint[frame_idx][link.source] * link.source_bone;
        sum += std::atan2(a.cross(b).norm(), a.dot(b));
        ++count;
    }
    return count > 0 ? sum / count : 0.0;
}

/// Fastest local rotation between neighbouring poses, rad/s.
std::vector<double> joint_speeds(const std::vector<Pose>& poses, double frame_rate)
{
    std::vector<double> speeds;
    for (std::size_t f = 0; f + 1 < poses.size(); ++f) {
        double angle = 0.0;
        for (std::size_t j = 0; j < poses[f].parent_from_joint.size(); ++j) {
            angle = std::max(angle, rotation_angle(poses[f].parent_from_joint[j], poses[f + 1].parent_from_joint[j]));
        }
        speeds.push_back(angle * frame_rate);
    }
    return speeds;
}

/// Whether a joint other than the root is further from rest than the limit of the options or its own.
bool exceeds_limits(const Pose& pose, const std::vector<Link>& links, double max_joint_angle)
{
    for (std::size_t j = 1; j < pose.parent_from_joint.size(); ++j) {
        const double limit = std::min(links[j].limit, max_joint_angle);
        if (limit >= M_PI) continue;
        const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
        if (rotation_angle(pose.parent_from_joint[j], identity) > limit) return true;
    }
    return false;
}

}  // namespace

std::vector<Eigen::Matrix3d> rest_alignment(const MotionClip& clip, const JointMap& map,
                                            const Eigen::Ref<const Points>& joint_positions)
{
    return align(resolve(clip, map, joint_positions));
}

PoseSet retarget_clip(const MotionClip& clip, const JointMap& map, const Eigen::Ref<const Points>& joint_positions,
                      const RetargetOptions& options, RetargetReport& report)
{
    const std::vector<Link> links = resolve(clip, map, joint_positions);
    report = RetargetReport();
    report.clip_name = clip.name;
    report.num_frames = clip.num_frames();
    report.num_skipped = std::min(map.skip_first_frames, clip.num_frames());
    require_input(report.num_skipped < clip.num_frames(), "clip {}: has {} frames and the joint map {} skips {}",
                  clip.name, clip.num_frames(), map.path, map.skip_first_frames);

    const std::vector<Pose> all = transfer(clip, links, joint_positions, report.num_skipped);
    const std::vector<Pose> real(all.begin() + report.num_skipped, all.end());
    const std::vector<double> speeds = joint_speeds(real, clip.frame_rate);
    std::vector<bool> glitch(real.size(), false);
    for (std::size_t f = 0; f < speeds.size(); ++f) {
        report.max_joint_speed = std::max(report.max_joint_speed, speeds[f]);
        if (speeds[f] > options.max_joint_speed) glitch[f] = glitch[f + 1] = true;
    }
    report.num_glitch_frames = static_cast<int>(std::count(glitch.begin(), glitch.end(), true));

    PoseSet poses;
    poses.clip_names.push_back(clip.name);
    poses.clip_frame_rates.push_back(clip.frame_rate);
    const double step = options.frame_rate > 0 ? std::max(1.0, clip.frame_rate / options.frame_rate) : 1.0;
    for (int k = 0;; ++k) {
        const auto f = static_cast<std::size_t>(std::llround(k * step));
        if (f >= real.size()) break;
        if (glitch[f]) {
            ++report.num_dropped_glitches;
        } else if (exceeds_limits(real[f], links, options.max_joint_angle)) {
            ++report.num_dropped_angles;
        } else {
            const int frame_idx = static_cast<int>(f) + report.num_skipped;
            poses.poses.push_back(real[f]);
            poses.clip_idx.push_back(0);
            poses.frame_idx.push_back(frame_idx);
            report.mean_direction_error += direction_error(real[f], clip, frame_idx, links);
        }
    }
    report.num_poses = poses.size();
    if (report.num_poses > 0) report.mean_direction_error /= report.num_poses;
    return poses;
}

void append_poses(PoseSet& poses, const PoseSet& addition)
{
    const int offset = static_cast<int>(poses.clip_names.size());
    poses.poses.insert(poses.poses.end(), addition.poses.begin(), addition.poses.end());
    for (const int clip : addition.clip_idx) poses.clip_idx.push_back(clip + offset);
    poses.frame_idx.insert(poses.frame_idx.end(), addition.frame_idx.begin(), addition.frame_idx.end());
    poses.clip_names.insert(poses.clip_names.end(), addition.clip_names.begin(), addition.clip_names.end());
    poses.clip_frame_rates.insert(poses.clip_frame_rates.end(), addition.clip_frame_rates.begin(),
                                  addition.clip_frame_rates.end());
}

}  // namespace ndg
