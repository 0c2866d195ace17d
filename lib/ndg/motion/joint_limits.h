// SPDX-License-Identifier: Apache-2.0
// Ranges of motion of our joints (configs/joint-limits.json names the published source of each).
#pragma once

#include "ndg/body/skeleton.h"

#include <array>
#include <string>
#include <vector>

namespace ndg {

/// Range of one joint against another, in the axes of the neutral posture (ClinicalFrames): x to the left, y up, z
/// forward; a joint's motion from that posture is split into a swing and a twist about its long axis.
struct JointRange {
    int joint = 0, base = 0;   ///< base: a joint above
    int long_axis = 1;         ///< 0, 1, 2: x, y, z
    bool thumb_axes = false;   ///< z is the thumb's axis of flexion, -y points along it
    bool swing_after = false;  ///< swing in axes that have turned with the twist (the wrist's with the forearm)
    /// Swings within an ellipse about the middle of the ranges (ball joints), rather than each angle within its own.
    /// The twist is then counted from the swing to that middle, because the whole sphere has no frame without a seam.
    bool ellipse = false;
    std::array<double, 3> low{}, high{};  ///< rad, about x, y, z
};

struct JointLimitTable {
    std::string path;
    std::vector<JointRange> ranges;  ///< ascending joints
};

/// Joints without a side are given once and mirrored. Throws InputError naming file, item and value: not JSON, unknown
/// key, joint or source, a swing of more than 160 degrees from its middle.
JointLimitTable read_joint_limits(const std::string& path);

/// The table on a body.
class JointLimits {
public:
    /// `joint_positions`: J x 3 rest positions on the standard skeleton.
    JointLimits(const JointLimitTable& table, const Eigen::Ref<const Points>& joint_positions);

    /// Radians by which each joint leaves its range (the larger of swing and twist), J; 0 within, or without a range.
    /// `parent_from_joint`: J local rotations.
    std::vector<double> excess(const std::vector<Eigen::Matrix3d>& parent_from_joint) const;

    /// The pose with each joint brought to the border of its range; joints within keep their motion against their
    /// base. A continuous function of the pose: within 15 degrees of where a swing or twist of half a turn has no
    /// direction (far outside every range) the result moves to the posture the range is measured from.
    std::vector<Eigen::Matrix3d> clamped(const std::vector<Eigen::Matrix3d>& parent_from_joint) const;

private:
    struct Limit {
        JointRange range;
        Eigen::Matrix3d base_axes, joint_axes;  ///< axes of the range in the rest frames of base and joint
    };
    std::vector<Limit> limits_;
};

}  // namespace ndg
