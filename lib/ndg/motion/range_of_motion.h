// SPDX-License-Identifier: Apache-2.0
// How far the joints of a set of poses go, against published ranges.
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/motion/joint_limits.h"

#include <string>
#include <vector>

namespace ndg {

/// One clinical angle over all poses, radians.
struct AngleRange {
    std::string angle;  ///< of clinical_angle_names()
    double min = 0, percentile_1 = 0, median = 0, percentile_99 = 0, max = 0;
    bool has_limits = false;
    double low = 0, high = 0;    ///< published range; of groups of joints the sum
    double share_outside = 0.0;  ///< of the poses, beyond it by more than half a degree
};

/// One joint over all poses: how far it leaves its range (JointLimits::excess).
struct JointExcess {
    std::string joint;
    double share_outside = 0.0;  ///< of the poses, by more than half a degree
    double worst = 0.0;          ///< rad
    int worst_pose = -1;
};

struct RangeOfMotion {
    int num_poses = 0;
    std::vector<AngleRange> angles;   ///< those of the pelvis left out, which is where the body stands
    std::vector<JointExcess> joints;  ///< all with a range; empty without limits
};

/// `joint_positions`: J x 3 rest positions of the body the poses are of; `limits` may be nullptr. Percentiles are of
/// the sorted values, interpolated. Throws InputError for no pose.
RangeOfMotion range_of_motion(const PoseSet& poses, const Eigen::Ref<const Points>& joint_positions,
                              const JointLimitTable* limits);

/// A table in degrees, a line an angle, and a line for each joint that leaves its range.
std::string range_of_motion_table(const RangeOfMotion& ranges);
/// All figures in degrees, as JSON.
std::string range_of_motion_json(const RangeOfMotion& ranges);

}  // namespace ndg
