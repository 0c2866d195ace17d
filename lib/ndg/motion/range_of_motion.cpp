// SPDX-License-Identifier: Apache-2.0
#include "ndg/motion/range_of_motion.h"

#include "ndg/core/error.h"
#include "ndg/motion/clinical_angles.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

constexpr double degree = M_PI / 180.0, tolerance = 0.5 * degree;

/// Value below which a share of the sorted values lies.
double percentile(const std::vector<double>& sorted, double share)
{
    const double at = share * static_cast<double>(sorted.size() - 1);
    const auto i = static_cast<std::size_t>(at);
    const std::size_t next = std::min(i + 1, sorted.size() - 1);
    return sorted[i] + (at - static_cast<double>(i)) * (sorted[next] - sorted[i]);
}

/// In degrees to the tenth, without a negative zero.
double rounded(double angle)
{
    return std::round(10.0 * angle / degree) / 10.0 + 0.0;
}

const JointRange* find_range(const JointLimitTable& limits, int joint)
{
    for (const JointRange& range : limits.ranges) {
        if (range.joint == joint) return &range;
    }
    return nullptr;
}

/// Published range of an angle: of its last joint against the base, or the sum over its joints.
void add_limits(AngleRange& result, const ClinicalAxis& axis, const JointLimitTable& limits)
{
    if (axis.direction) return;
    const auto k = static_cast<std::size_t>(axis.axis);
    double low = 0.0, high = 0.0;
    const JointRange* last = find_range(limits, axis.joints.back());
    if (last != nullptr && last->base == axis.base) {
        low = last->low[k];
        high = last->high[k];
    } else {
        for (const int joint : axis.joints) {
            const JointRange* range = find_range(limits, joint);
            if (range == nullptr) return;
            low += range->low[k];
            high += range->high[k];
        }
    }
    double sign = axis.sign;
    // Ranges of the right thumb are in the mirror image of the left one's axes.
    const std::string& name = standard_skeleton().joint_names[std::size_t(axis.joints.back())];
    if (last != nullptr && last->thumb_axes && name.rfind("right_", 0) == 0) sign = axis.axis == 0 ? 1.0 : -1.0;
    result.has_limits = true;
    result.low = sign > 0 ? low : -high;
    result.high = sign > 0 ? high : -low;
}

std::vector<JointExcess> joint_excess(const PoseSet& poses, const Eigen::Ref<const Points>& joint_positions,
                                      const JointLimitTable& table)
{
    const JointLimits limits(table, joint_positions);
    std::vector<JointExcess> result;
    for (const JointRange& range : table.ranges) {
        JointExcess entry;
        entry.joint = standard_skeleton().joint_names[std::size_t(range.joint)];
        result.push_back(entry);
    }
    for (int i = 0; i < poses.size(); ++i) {
        const std::vector<double> excess = limits.excess(poses.poses[std::size_t(i)].parent_from_joint);
        for (std::size_t k = 0; k < result.size(); ++k) {
            const double beyond = excess[std::size_t(table.ranges[k].joint)];
            if (beyond > tolerance) result[k].share_outside += 1.0 / poses.size();
            if (beyond > result[k].worst) {
                result[k].worst = beyond;
                result[k].worst_pose = i;
            }
        }
    }
    return result;
}

}  // namespace

RangeOfMotion range_of_motion(const PoseSet& poses, const Eigen::Ref<const Points>& joint_positions,
                              const JointLimitTable* limits)
{
    require_input(poses.size() > 0, "there is no pose whose range of motion to measure");
    const ClinicalFrames frames(joint_positions);
    const auto num_angles = clinical_angle_names().size();
    std::vector<std::vector<double>> values(num_angles);
    for (const Pose& pose : poses.poses) {
        const std::vector<double> angles = frames.angles(pose);
        for (std::size_t k = 0; k < num_angles; ++k) values[k].push_back(angles[k]);
    }
    RangeOfMotion result;
    result.num_poses = poses.size();
    for (std::size_t k = 0; k < num_angles; ++k) {
        const ClinicalAxis axis = clinical_axis(static_cast<int>(k));
        if (axis.base < 0) continue;
        std::vector<double>& sorted = values[k];
        std::sort(sorted.begin(), sorted.end());
        AngleRange range;
        range.angle = clinical_angle_names()[k];
        range.min = sorted.front();
        range.percentile_1 = percentile(sorted, 0.01);
        range.median = percentile(sorted, 0.5);
        range.percentile_99 = percentile(sorted, 0.99);
        range.max = sorted.back();
        if (limits != nullptr) add_limits(range, axis, *limits);
        if (range.has_limits) {
            const auto outside = std::count_if(sorted.begin(), sorted.end(), [&](double value) {
                return value < range.low - tolerance || value > range.high + tolerance;
            });
            range.share_outside = static_cast<double>(outside) / poses.size();
        }
        result.angles.push_back(range);
    }
    if (limits != nullptr) result.joints = joint_excess(poses, joint_positions, *limits);
    return result;
}

std::string range_of_motion_table(const RangeOfMotion& ranges)
{
    std::string text = fmt::format("{:<34} {:>7} {:>7} {:>7} {:>7} {:>7}   {:>15} {:>8}\n", "angle (degrees)", "min",
                                   "1 %", "median", "99 %", "max", "published", "outside");
    for (const AngleRange& range : ranges.angles) {
        text += fmt::format("{:<34} {:>7.1f} {:>7.1f} {:>7.1f} {:>7.1f} {:>7.1f}", range.angle, rounded(range.min),
                            rounded(range.percentile_1), rounded(range.median), rounded(range.percentile_99),
                            rounded(range.max));
        if (range.has_limits) {
            text += fmt::format("   {:>6.1f} to {:>5.1f} {:>6.1f} %", rounded(range.low), rounded(range.high),
                                100.0 * range.share_outside);
        }
        text += "\n";
    }
    for (const JointExcess& joint : ranges.joints) {
        if (joint.share_outside == 0.0) continue;
        text += fmt::format("{}: beyond its range in {:.1f} % of the poses, by up to {:.1f} degrees (pose {})\n",
                            joint.joint, 100.0 * joint.share_outside, joint.worst / degree, joint.worst_pose);
    }
    return text;
}

std::string range_of_motion_json(const RangeOfMotion& ranges)
{
    nlohmann::ordered_json root;
    root["num_poses"] = ranges.num_poses;
    root["unit"] = "degree";
    for (const AngleRange& range : ranges.angles) {
        nlohmann::ordered_json& entry = root["angles"][range.angle];
        entry["min"] = range.min / degree;
        entry["percentile_1"] = range.percentile_1 / degree;
        entry["median"] = range.median / degree;
        entry["percentile_99"] = range.percentile_99 / degree;
        entry["max"] = range.max / degree;
        if (!range.has_limits) continue;
        entry["published"] = {range.low / degree, range.high / degree};
        entry["share_outside"] = range.share_outside;
    }
    for (const JointExcess& joint : ranges.joints) {
        nlohmann::ordered_json& entry = root["joints"][joint.joint];
        entry["share_outside"] = joint.share_outside;
        entry["worst"] = joint.worst / degree;
        if (joint.worst_pose >= 0) entry["worst_pose"] = joint.worst_pose;
    }
    return root.dump(2) + "\n";
}

}  // namespace ndg
