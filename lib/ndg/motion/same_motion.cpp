// SPDX-License-Identifier: Apache-2.0
#include "ndg/motion/same_motion.h"

#include "ndg/body/skeleton.h"
#include "ndg/geometry/rotation.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

namespace ndg {

namespace {

constexpr int most_compared = 64;

struct Bone {
    int joint;
    Eigen::Vector3d rest;  ///< about where it points at rest
};

const std::vector<Bone>& compared_bones()
{
    static const std::vector<Bone> bones = [] {
        std::vector<Bone> result;
        for (const double side : {1.0, -1.0}) {
            const std::string s = side > 0 ? "left_" : "right_";
            for (const char* joint : {"upper_arm", "forearm"})
                result.push_back({standard_skeleton().joint(s + joint), Eigen::Vector3d(side, -1, 0).normalized()});
            for (const char* joint : {"thigh", "shin"})
                result.push_back({standard_skeleton().joint(s + joint), -Eigen::Vector3d::UnitY()});
        }
        return result;
    }();
    return bones;
}

/// Where the bone points, in the root's frame.
Eigen::Vector3d direction(const Pose& pose, const Bone& bone)
{
    Eigen::Vector3d result = bone.rest;
    for (int j = bone.joint; j > 0; j = standard_skeleton().parents[j]) result = pose.parent_from_joint[j] * result;
    return result;
}

/// With pose k + shift of b beside pose k of a.
bool same_at(const PoseRange& a, const PoseRange& b, int shift, const SameMotionOptions& options)
{
    const int begin = std::max(0, -shift), end = std::min(a.count, b.count - shift);
    if (end - begin < options.least_poses || end <= begin) return false;
    const auto pose = [](const PoseRange& range, int k) -> const Pose& { return range.poses->poses[range.first + k]; };
    const Pose &first_a = pose(a, begin), &first_b = pose(b, begin + shift);
    const int step = std::max(1, (end - begin) / most_compared);
    double angle = 0.0, way = 0.0;
    int count = 0;
    for (int k = begin; k < end; k += step) {
        const Pose &x = pose(a, k), &y = pose(b, k + shift);
        for (const Bone& bone : compared_bones()) {
            const Eigen::Vector3d in_a = direction(x, bone), in_b = direction(y, bone);
            angle += std::atan2(in_a.cross(in_b).norm(), in_a.dot(in_b));
        }
        angle += rotation_angle(Eigen::Matrix3d(first_a.parent_from_joint[0].transpose() * x.parent_from_joint[0]),
                                Eigen::Matrix3d(first_b.parent_from_joint[0].transpose() * y.parent_from_joint[0]));
        way += std::abs((x.root_translation - first_a.root_translation).norm() -
                        (y.root_translation - first_b.root_translation).norm());
        ++count;
    }
    const auto num_angles = static_cast<double>(count * (compared_bones().size() + 1));
    return angle <= options.angle * num_angles && way <= options.way * count;
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
