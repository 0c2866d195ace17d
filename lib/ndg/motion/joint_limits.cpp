// SPDX-License-Identifier: Apache-2.0
#include "ndg/motion/joint_limits.h"

#include "ndg/core/error.h"
#include "ndg/geometry/rotation.h"
#include "ndg/motion/clinical_angles.h"

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

/// Width of the zone before half a turn in which clamped angles go to the middle of their range.
constexpr double seam = 15.0 * M_PI / 180.0;

struct SwingTwist {
    Eigen::Vector3d swing = Eigen::Vector3d::Zero();  ///< rotation vector across the long axis
    double twist = 0.0;                               ///< about the long axis, (-pi, pi]
};

SwingTwist split(const Eigen::Matrix3d& rotation, int long_axis, bool swing_after)
{
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(long_axis);
    SwingTwist result;
    result.twist = twist_angle(rotation, axis);
    const Eigen::Matrix3d twist = rotation_of(result.twist * axis);
    result.swing = rotation_vector(rotation * twist.transpose());
    if (swing_after) result.swing = (twist.transpose() * result.swing).eval();
    result.swing[long_axis] = 0.0;  // only rounding
    return result;
}

Eigen::Matrix3d join(const SwingTwist& parts, int long_axis, bool swing_after)
{
    const Eigen::Matrix3d twist = rotation_of(parts.twist * Eigen::Vector3d::Unit(long_axis));
    const Eigen::Matrix3d swing = rotation_of(parts.swing);
    if (swing_after) return twist * swing;
    return swing * twist;
}

double middle(const JointRange& range, int axis)
{
    return 0.5 * (range.low[axis] + range.high[axis]);
}

double half_width(const JointRange& range, int axis)
{
    return 0.5 * (range.high[axis] - range.low[axis]);
}

/// Rotation from the neutral posture to the one the range is measured from.
Eigen::Matrix3d centre(const JointRange& range)
{
    Eigen::Vector3d swing = Eigen::Vector3d::Zero();
    if (!range.ellipse) return Eigen::Matrix3d::Identity();
    for (int axis = 0; axis < 3; ++axis) {
        if (axis != range.long_axis) swing[axis] = middle(range, axis);
    }
    return rotation_of(swing);
}

/// Swing on the border or within, and how far it was outside.
Eigen::Vector3d clamp_swing(const Eigen::Vector3d& swing, const JointRange& range, double& excess)
{
    Eigen::Vector3d result = swing;
    if (range.ellipse) {
        double square = 0.0;
        for (int axis = 0; axis < 3; ++axis) {
            if (axis != range.long_axis) square += std::pow(swing[axis] / half_width(range, axis), 2);
        }
        if (square > 1.0) result /= std::sqrt(square);
    } else {
        for (int axis = 0; axis < 3; ++axis) {
            if (axis != range.long_axis) result[axis] = std::clamp(swing[axis], range.low[axis], range.high[axis]);
        }
    }
    excess = (result - swing).norm();
    return result;
}

/// 1 up to `seam` before half a turn, then falling to 0.
double fade(double angle)
{
    return std::clamp((M_PI - std::abs(angle)) / seam, 0.0, 1.0);
}

SwingTwist clamp_parts(const SwingTwist& parts, const JointRange& range, double& excess)
{
    SwingTwist result;
    double swing_excess = 0.0;
    result.swing = clamp_swing(parts.swing, range, swing_excess);
    const double twist_middle = middle(range, range.long_axis), twist_half = half_width(range, range.long_axis);
    const double turned = std::remainder(parts.twist - twist_middle, 2.0 * M_PI);
    const double twist_excess = std::max(0.0, std::abs(turned) - twist_half);
    const double swing_fade = fade(parts.swing.norm());
    const double twist = std::clamp(turned, -twist_half, twist_half) * (twist_excess > 0 ? fade(turned) : 1.0);
    excess = std::max(swing_excess, twist_excess);
    // A swing of half a turn could as well be the opposite one, and has no twist.
    result.swing *= swing_fade;
    result.twist = twist_middle + swing_fade * twist;
    return result;
}

Eigen::Matrix3d thumb_axes(const Points& positions, const std::vector<Eigen::Matrix3d>& neutral_from_rest, bool right)
{
    const Skeleton& skeleton = standard_skeleton();
    const std::string side = right ? "right_" : "left_";
    const Eigen::RowVector3d base = positions.row(skeleton.joint(side + "thumb_1"));
    const Eigen::Matrix3d& hand = neutral_from_rest[skeleton.joint(side + "hand")];
    const Eigen::Vector3d along =
        hand * (positions.row(skeleton.joint(side + "thumb_2")) - base).transpose().normalized();
    const Eigen::Vector3d to_pinky = hand * (positions.row(skeleton.joint(side + "pinky_1")) - base).transpose();
    const Eigen::Vector3d flexion = along.cross(to_pinky);
    require_input(flexion.norm() > 1e-9, "the body's {}thumb points at the base of its little finger", side);
    Eigen::Matrix3d axes;
    axes.col(1) = -along;
    // As of the mirrored side: ranges of the right are given with y and z turned about.
    axes.col(2) = (right ? -1.0 : 1.0) * flexion.normalized();
    axes.col(0) = axes.col(1).cross(axes.col(2));
    return axes;
}

}  // namespace

JointLimits::JointLimits(const JointLimitTable& table, const Eigen::Ref<const Points>& joint_positions)
{
    const std::vector<Eigen::Matrix3d> neutral = ClinicalFrames(joint_positions).world_from_rest();
    for (const JointRange& range : table.ranges) {
        Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
        if (range.thumb_axes) {
            const bool right = standard_skeleton().joint_names[range.joint].rfind("right_", 0) == 0;
            axes = thumb_axes(joint_positions, neutral, right);
        }
        limits_.push_back(
            {range, neutral[range.base].transpose() * axes * centre(range), neutral[range.joint].transpose() * axes});
    }
}

std::vector<double> JointLimits::excess(const std::vector<Eigen::Matrix3d>& parent_from_joint) const
{
    const Skeleton& skeleton = standard_skeleton();
    std::vector<double> result(parent_from_joint.size(), 0.0);
    for (const Limit& limit : limits_) {
        const JointRange& range = limit.range;
        Eigen::Matrix3d base_from_joint = parent_from_joint[range.joint];
        for (int j = skeleton.parents[range.joint]; j != range.base; j = skeleton.parents[j]) {
            base_from_joint = (parent_from_joint[j] * base_from_joint).eval();
        }
        const Eigen::Matrix3d motion = limit.base_axes.transpose() * base_from_joint * limit.joint_axes;
        clamp_parts(split(motion, range.long_axis, range.swing_after), range, result[range.joint]);
    }
    return result;
}

std::vector<Eigen::Matrix3d> JointLimits::clamped(const std::vector<Eigen::Matrix3d>& parent_from_joint) const
{
    const Skeleton& skeleton = standard_skeleton();
    std::vector<Eigen::Matrix3d> result = parent_from_joint;
    for (const Limit& limit : limits_) {
        const JointRange& range = limit.range;
        Eigen::Matrix3d before = Eigen::Matrix3d::Identity(), after = Eigen::Matrix3d::Identity();
        for (int j = skeleton.parents[range.joint]; j != range.base; j = skeleton.parents[j]) {
            before = (parent_from_joint[j] * before).eval();
            after = (result[j] * after).eval();
        }
        Eigen::Matrix3d base_from_joint = before * parent_from_joint[range.joint];
        const Eigen::Matrix3d motion = limit.base_axes.transpose() * base_from_joint * limit.joint_axes;
        double outside = 0.0;
        const SwingTwist inside = clamp_parts(split(motion, range.long_axis, range.swing_after), range, outside);
        // A joint within its range keeps its rotation to the last digit, unless one between has been moved.
        if (outside == 0.0 && before == after) continue;
        if (outside > 0.0) {
            base_from_joint =
                limit.base_axes * join(inside, range.long_axis, range.swing_after) * limit.joint_axes.transpose();
        }
        result[range.joint] = to_quaternion(after.transpose() * base_from_joint).toRotationMatrix();
    }
    return result;
}

}  // namespace ndg
