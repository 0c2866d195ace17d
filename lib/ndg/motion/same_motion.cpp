// SPDX-License-Identifier: Apache-2.0
#include "ndg/motion/same_motion.h"

#include "ndg/body/skeleton.h"
#include "ndg/geometry/rotation.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace ndg {

namespace {

constexpr int most_compared = 64;

const std::vector<int>& compared_joints()
{
    static const std::vector<int> joints = [] {
        std::vector<int> result = {0};
        for (const std::string side : {"left_", "right_"}) {
            for (const char* joint : {"upper_arm", "forearm", "thigh", "shin"})
                result.push_back(standard_skeleton().joint(side + joint));
        }
        return result;
    }();
    return joints;
}

/// With pose k + shift of b beside pose k of a.
bool same_at(const PoseRange& a, const PoseRange& b, int shift, const SameMotionOptions& options)
{
    const int begin = std::max(0, -shift), end = std::min(a.count, b.count - shift);
    if (end - begin < options.least_poses || end <= begin) return false;
    const auto pose = [](const PoseRange& range, int k) -> const Pose& { return range.poses->poses[range.first + k]; };
    const Eigen::Vector3d offset = pose(a, begin).root_translation - pose(b, begin + shift).root_translation;
    const int step = std::max(1, (end - begin) / most_compared);
    double angle = 0.0, way = 0.0;
    int count = 0;
    for (int k = begin; k < end; k += step) {
        const Pose &x = pose(a, k), &y = pose(b, k + shift);
        for (const int joint : compared_joints())
            angle += rotation_angle(x.parent_from_joint[joint], y.parent_from_joint[joint]);
        way += (x.root_translation - y.root_translation - offset).norm();
        ++count;
    }
    return angle <= options.angle * count * static_cast<double>(compared_joints().size()) && way <= options.way * count;
}

}  // namespace

bool same_motion(const PoseRange& a, const PoseRange& b, const SameMotionOptions& options)
{
    if (std::abs(a.count - b.count) > options.largest_shift) return false;
    for (int shift = -options.largest_shift; shift <= options.largest_shift; ++shift) {
        if (same_at(a, b, shift, options)) return true;
    }
    return false;
}

}  // namespace ndg
