// SPDX-License-Identifier: Apache-2.0
#include "ndg/motion/resample_poses.h"

#include "ndg/core/error.h"
#include "ndg/geometry/rotation.h"

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

constexpr double same_time = 1e-6;  // frames of the clip

Pose between(const Pose& a, const Pose& b, double share)
{
    Pose pose = a;
    for (std::size_t j = 0; j < a.parent_from_joint.size(); ++j) {
        const Eigen::Quaterniond from = to_quaternion(a.parent_from_joint[j]),
                                 to = to_quaternion(b.parent_from_joint[j]);
        pose.parent_from_joint[j] = from.slerp(share, to).toRotationMatrix();
    }
    pose.root_translation = (1.0 - share) * a.root_translation + share * b.root_translation;
    return pose;
}

}  // namespace

PoseSet resample_poses(const PoseSet& poses, double frame_rate)
{
    require(poses.clip_names.size() == 1, "poses of {} clips cannot be resampled as one", poses.clip_names.size());
    PoseSet result;
    result.clip_names = poses.clip_names;
    result.clip_frame_rates = {frame_rate > 0.0 ? frame_rate : poses.clip_frame_rates[0]};
    if (poses.size() == 0) return result;
    const std::vector<int>& times = poses.frame_idx;  // ascending
    const double frames_per_frame = poses.clip_frame_rates[0] / result.clip_frame_rates[0];
    for (int f = 0;; ++f) {
        const double time = times.front() + f * frames_per_frame;
        if (time > times.back() + same_time) return result;
        const auto after = std::lower_bound(times.begin(), times.end(), time - same_time);
        const std::size_t k = std::size_t(after - times.begin());
        const bool exact = times[k] - time <= same_time;
        result.poses.push_back(
            exact ? poses.poses[k]
                  : between(poses.poses[k - 1], poses.poses[k], (time - times[k - 1]) / (times[k] - times[k - 1])));
        result.clip_idx.push_back(0);
        result.frame_idx.push_back(f);
    }
}

}  // namespace ndg
