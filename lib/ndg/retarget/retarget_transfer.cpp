// SPDX-License-Identifier: Apache-2.0
#include "ndg/retarget/retarget_transfer.h"

#include "ndg/core/error.h"
#include "ndg/geometry/rotation.h"
#include "ndg/motion/clinical_angles.h"

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

using Link = RotationTransfer::Link;

constexpr double shortest_bone = 1e-6;

/// An elbow counts as a hinge where it bends by at least this much (sine) in so many frames (a few would all seem to
/// have one axis), and where its bends add up to nearly the sum of their lengths; it is looked for in about so many
/// frames. A turn beyond half a right angle is no difference of rest poses but an elbow that bends backwards.
constexpr double least_hinge_bend = 0.17, least_hinge_share = 0.97, largest_hinge_turn = 0.25 * M_PI + 0.1;
constexpr int least_bent_frames = 10, max_hinge_frames = 1000;

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
        link.toward = skeleton.joint(entry.toward);
        link.bone_from = clip.find_joint(entry.bone_from);
        if (!entry.bone_to.empty()) {
            link.bone_to = clip.find_joint(entry.bone_to);
            link.bone_bends = !link.sole && clip.parents[link.bone_to] != link.bone_from;
        }
        link.source_bone = source_vector(clip, entry.bone_from, entry.bone_to);
        link.our_bone = (joint_positions.row(link.toward) - joint_positions.row(j)).transpose();
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

/// Source bones that carry twist: that of the joint itself or of the nearest ancestor with an aligned bone.
std::vector<Eigen::Vector3d> find_twist_axes(const std::vector<Link>& links)
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

/// The part about `axis` of the rotation between the joints that a link blends, in every frame: each angle is the one
/// nearest to that of the frame before, the median within half a turn. Where a bone is bent back on itself its twist
/// has no angle; such frames keep the one before.
std::vector<double> follow_twist(const MotionClip& clip, const Link& link, const Eigen::Vector3d& axis)
{
    constexpr double least_cosine = -0.98;
    std::vector<double> angles;
    double last = 0.0;
    for (const std::vector<Eigen::Matrix3d>& world : clip.world_from_joint) {
        const Eigen::Matrix3d relative = world[link.source].transpose() * world[link.blend_with];
        if (axis.dot(relative * axis) > least_cosine) {
            const double angle = twist_angle(relative, axis);
            last = angles.empty() ? angle : angle + 2.0 * M_PI * std::round((last - angle) / (2.0 * M_PI));
        }
        angles.push_back(last);
    }
    if (angles.empty()) return angles;
    std::vector<double> sorted = angles;
    std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(sorted.size() / 2), sorted.end());
    const double turns = 2.0 * M_PI * std::round(sorted[sorted.size() / 2] / (2.0 * M_PI));
    for (double& angle : angles) angle -= turns;
    return angles;
}

/// Length of hip-knee-ankle averaged over both legs; `joints` are hip, knee and ankle of each.
double leg_length(const Eigen::Ref<const Points>& positions, const std::array<int, 6>& joints)
{
    double length = 0.0;
    for (std::size_t side = 0; side < 2; ++side) {
        const int* leg = joints.data() + 3 * side;
        length += 0.5 * (positions.row(leg[1]) - positions.row(leg[0])).norm();
        length += 0.5 * (positions.row(leg[2]) - positions.row(leg[1])).norm();
    }
    return length;
}

std::array<int, 6> our_leg_joints()
{
    const Skeleton& skeleton = standard_skeleton();
    return {skeleton.joint("left_thigh"),  skeleton.joint("left_shin"),  skeleton.joint("left_foot"),
            skeleton.joint("right_thigh"), skeleton.joint("right_shin"), skeleton.joint("right_foot")};
}

/// How far the source's elbow axis is turned about the upper arm from ours, rad; 0 where its elbow is no hinge or
/// hardly bends. In our neutral posture the elbow bends the hanging forearm forward.
double elbow_turn(const MotionClip& clip, const std::vector<Link>& links, const std::vector<Eigen::Matrix3d>& alignment,
                  const std::vector<Eigen::Matrix3d>& neutral_from_rest, int upper_arm, int forearm)
{
    const Eigen::Matrix3d rest_from_neutral = neutral_from_rest[upper_arm].transpose();
    const Eigen::Vector3d forward = rest_from_neutral.col(2), lateral = rest_from_neutral.col(0);
    const Eigen::Vector3d forearm_bone = links[forearm].our_bone.normalized();
    // The bend is a vector in the plane across the upper arm, as long as the sine of its angle.
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double length = 0.0;
    int num_bent = 0;
    const int step = std::max(1, clip.num_frames() / max_hinge_frames);
    for (int f = 0; f < clip.num_frames(); f += step) {
        const std::vector<Eigen::Matrix3d>& world = clip.world_from_joint[f];
        const Eigen::Vector3d bent = alignment[upper_arm].transpose() * world[links[upper_arm].source].transpose() *
                                     world[links[forearm].source] * alignment[forearm] * forearm_bone;
        const Eigen::Vector2d bend(bent.dot(forward), bent.dot(lateral));
        sum += bend.norm() * bend;
        length += bend.squaredNorm();
        if (bend.norm() > least_hinge_bend) ++num_bent;
    }
    if (num_bent < least_bent_frames || sum.norm() < least_hinge_share * length) return 0.0;
    const double turn = std::atan2(sum.y(), sum.x());
    return std::abs(turn) <= largest_hinge_turn ? turn : 0.0;
}

/// Turns the alignment of the upper arms about themselves so that the elbows bend about our axis. That of the hands
/// stays: what the arm turns is made up for between elbow and wrist, as pronation does.
void align_elbows(const MotionClip& clip, const std::vector<Link>& links,
                  const Eigen::Ref<const Points>& joint_positions, std::vector<Eigen::Matrix3d>& alignment)
{
    const Skeleton& skeleton = standard_skeleton();
    const std::vector<Eigen::Matrix3d> neutral_from_rest = ClinicalFrames(joint_positions).world_from_rest();
    for (const std::string side : {"left_", "right_"}) {
        const int upper_arm = skeleton.joint(side + "upper_arm"), forearm = skeleton.joint(side + "forearm");
        const int twist = skeleton.joint(side + "forearm_twist");
        if (!links[upper_arm].aligned() || !links[forearm].aligned()) continue;
        const double turn = elbow_turn(clip, links, alignment, neutral_from_rest, upper_arm, forearm);
        if (turn == 0.0) continue;
        // Neutral upper arms hang: "down" at rest is the bone itself, and turning lateral to forward is about it.
        const Eigen::Vector3d arm = neutral_from_rest[upper_arm].transpose() * -Eigen::Vector3d::UnitY();
        alignment[upper_arm] = alignment[upper_arm] * rotation_of(-turn * arm);
        const Eigen::Vector3d forearm_axis = alignment[forearm] * links[forearm].our_bone.normalized();
        const Eigen::Matrix3d turned =
            minimal_rotation(alignment[upper_arm] * links[forearm].our_bone, links[forearm].source_bone) *
            alignment[upper_arm];
        const double carried = twist_angle(turned * alignment[forearm].transpose(), forearm_axis);
        alignment[forearm] = turned;
        alignment[twist] = rotation_of(0.5 * carried * forearm_axis) * alignment[twist];
    }
}

}  // namespace

RotationTransfer::RotationTransfer(const MotionClip& clip, const JointMap& map,
                                   const Eigen::Ref<const Points>& joint_positions)
    : clip_(clip), links_(resolve(clip, map, joint_positions)), alignment_(align(links_))
{
    align_elbows(clip, links_, joint_positions, alignment_);
    twist_axes_ = find_twist_axes(links_);
    twist_angles_.resize(links_.size());
    for (std::size_t j = 0; j < links_.size(); ++j) {
        if (links_[j].twist_only && links_[j].blend_with >= 0)
            twist_angles_[j] = follow_twist(clip, links_[j], twist_axes_[j]);
    }
    has_bending_bones_ = std::any_of(links_.begin(), links_.end(), [](const Link& link) { return link.bone_bends; });
    const std::array<int, 6> ours = our_leg_joints();
    std::array<int, 6> source{};
    for (std::size_t k = 0; k < 6; ++k) source[k] = links_[ours[k]].source;
    source_hip_joints_ = {source[0], source[3]};
    root_rest_ = joint_positions.row(0).transpose();
    const Eigen::RowVector3d hips = 0.5 * (joint_positions.row(ours[0]) + joint_positions.row(ours[3]));
    hips_from_root_ = hips.transpose() - root_rest_;
    source_leg_length_ = leg_length(clip.zero_pose_positions, source);
    require_input(source_leg_length_ > shortest_bone, "clip {}: the legs have zero length", clip.name);
    scale_ = leg_length(joint_positions, ours) / source_leg_length_;
}

Eigen::Matrix3d RotationTransfer::source_rotation(int joint, int frame_idx) const
{
    while (links_[joint].source < 0) {
        joint = standard_skeleton().parents[joint];
        if (joint < 0) return Eigen::Matrix3d::Identity();
    }
    const Link& link = links_[joint];
    const std::vector<Eigen::Matrix3d>& world_from_source = clip_.world_from_joint[frame_idx];
    const Eigen::Matrix3d& first = world_from_source[link.source];
    if (link.blend_with < 0) return first;
    const Eigen::Matrix3d& second = world_from_source[link.blend_with];
    if (link.twist_only) {
        const double angle = link.fraction * twist_angles_[joint][frame_idx];
        return first * Eigen::AngleAxisd(angle, twist_axes_[joint]).toRotationMatrix();
    }
    return to_quaternion(first).slerp(link.fraction, to_quaternion(second)).toRotationMatrix();
}

std::vector<Eigen::Matrix3d> RotationTransfer::world_rotations(int frame_idx) const
{
    const Skeleton& skeleton = standard_skeleton();
    std::vector<Eigen::Matrix3d> world_from_joint(links_.size());
    Points source;
    if (has_bending_bones_) source = clip_.joint_positions(frame_idx);
    for (int j = 0; j < skeleton.num_joints(); ++j) {
        const int parent = skeleton.parents[j];
        const Link& link = links_[j];
        if (link.source < 0) {
            world_from_joint[j] = parent >= 0 ? world_from_joint[parent] : Eigen::Matrix3d::Identity();
            continue;
        }
        world_from_joint[j] = source_rotation(j, frame_idx) * alignment_[j];
        if (!link.bone_bends) continue;
        const Eigen::Vector3d bone = (source.row(link.bone_to) - source.row(link.bone_from)).transpose();
        if (bone.norm() <= shortest_bone) continue;
        world_from_joint[j] = minimal_rotation(world_from_joint[j] * link.our_bone, bone) * world_from_joint[j];
    }
    return world_from_joint;
}

Eigen::Vector3d RotationTransfer::source_hips(const Points& source_positions) const
{
    return 0.5 *
           (source_positions.row(source_hip_joints_[0]) + source_positions.row(source_hip_joints_[1])).transpose();
}

Eigen::Vector3d RotationTransfer::root_translation(int frame_idx, int first_frame, const Eigen::Matrix3d& pelvis) const
{
    Eigen::Vector3d origin = scale_ * source_hips(clip_.joint_positions(first_frame));
    origin.y() = 0.0;
    const Eigen::Vector3d hips = scale_ * source_hips(clip_.joint_positions(frame_idx)) - origin;
    return hips - root_rest_ - pelvis * hips_from_root_;
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

std::vector<Eigen::Matrix3d> compose_rotations(const std::vector<Eigen::Matrix3d>& parent_from_joint)
{
    const Skeleton& skeleton = standard_skeleton();
    std::vector<Eigen::Matrix3d> world_from_joint = parent_from_joint;
    for (std::size_t j = 0; j < world_from_joint.size(); ++j) {
        const int parent = skeleton.parents[j];
        if (parent >= 0) world_from_joint[j] = world_from_joint[parent] * parent_from_joint[j];
    }
    return world_from_joint;
}

}  // namespace ndg
