// SPDX-License-Identifier: Apache-2.0
#include "ndg/motion/pose_sampling.h"

#include "ndg/core/error.h"
#include "ndg/motion/rotation.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace ndg {

namespace {

/// Room for rounding where a bound decides that a distance need not be computed.
constexpr double slack = 1e-9;

/// Joint rotations of all poses as quaternions; joints that never move are left out, for they add exactly 0.
class PoseTable {
public:
    explicit PoseTable(const std::vector<Pose>& poses) : num_poses_(static_cast<int>(poses.size()))
    {
        const std::size_t num_joints = poses.front().parent_from_joint.size();
        std::vector<int> joints;
        std::vector<double> spread;
        for (std::size_t j = 0; j < num_joints; ++j) {
            double sum = 0.0;
            bool moves = false;
            const Eigen::Matrix3d& first = poses.front().parent_from_joint[j];
            for (const Pose& pose : poses) {
                if (pose.parent_from_joint[j] == first) continue;
                moves = true;
                sum += (pose.parent_from_joint[j] - first).norm();
            }
            if (!moves) continue;
            joints.push_back(static_cast<int>(j));
            spread.push_back(sum);
        }
        // The joints that differ most first, so that a sum passes its limit early.
        std::vector<int> by_spread(joints.size());
        std::iota(by_spread.begin(), by_spread.end(), 0);
        std::stable_sort(by_spread.begin(), by_spread.end(), [&](int a, int b) { return spread[a] > spread[b]; });
        num_joints_ = static_cast<int>(joints.size());
        quaternions_.reserve(poses.size() * joints.size());
        for (const Pose& pose : poses) {
            for (const int k : by_spread) quaternions_.push_back(to_quaternion(pose.parent_from_joint[joints[k]]));
        }
    }

    int size() const { return num_poses_; }

    /// Distance of two poses, or any value above `limit` once the sum is above it.
    double distance(int a, int b, double limit = std::numeric_limits<double>::infinity()) const
    {
        const Eigen::Quaterniond* p = quaternions_.data() + static_cast<std::size_t>(a) * num_joints_;
        const Eigen::Quaterniond* q = quaternions_.data() + static_cast<std::size_t>(b) * num_joints_;
        double sum = 0.0;
        for (int j = 0; j < num_joints_ && sum <= limit; ++j) sum += rotation_angle(p[j], q[j]);
        return sum;
    }

private:
    int num_poses_ = 0, num_joints_ = 0;
    std::vector<Eigen::Quaterniond> quaternions_;
};

}  // namespace

double pose_distance(const Pose& a, const Pose& b)
{
    require(a.parent_from_joint.size() == b.parent_from_joint.size(), "poses of {} and {} joints cannot be compared",
            a.parent_from_joint.size(), b.parent_from_joint.size());
    double sum = 0.0;
    for (std::size_t j = 0; j < a.parent_from_joint.size(); ++j) {
        sum += rotation_angle(a.parent_from_joint[j], b.parent_from_joint[j]);
    }
    return sum;
}

void remove_root_motion(Pose& pose)
{
    pose.parent_from_joint[0].setIdentity();
    pose.root_translation.setZero();
}

PoseSampling farthest_point_sampling(const std::vector<Pose>& poses, int count, int first_idx)
{
    const int num_poses = static_cast<int>(poses.size());
    require_input(count >= 1 && count <= num_poses, "{} poses were asked for, there are {}", count, num_poses);
    require_input(first_idx >= 0 && first_idx < num_poses, "the first pose is {}, there are {}", first_idx, num_poses);
    const PoseTable table(poses);

    PoseSampling sampling;
    std::vector<double> distance(num_poses, std::numeric_limits<double>::infinity());  // to the nearest pick
    std::vector<int> nearest(num_poses, 0);                                            // which pick that is
    std::vector<double> between;                                                       // newest pick to all picks
    int next = first_idx;
    while (true) {
        const int pick = static_cast<int>(sampling.order.size());
        sampling.order.push_back(next);
        between.assign(pick + 1, 0.0);
#pragma omp parallel for schedule(static)
        for (int k = 0; k < pick; ++k) between[k] = table.distance(next, sampling.order[k]);
#pragma omp parallel for schedule(dynamic, 256)
        for (int i = 0; i < num_poses; ++i) {
            // d(i, new) >= d(old, new) - d(i, old): no nearer where d(old, new) >= 2 d(i, old).
            if (pick > 0 && between[nearest[i]] >= 2.0 * distance[i] + slack) continue;
            const double d = table.distance(i, next, distance[i]);
            if (d < distance[i]) {
                distance[i] = d;
                nearest[i] = pick;
            }
        }
        const auto farthest = std::max_element(distance.begin(), distance.end());
        sampling.covering_radius.push_back(*farthest);
        if (pick + 1 == count) break;
        require_input(*farthest > 0.0, "{} poses were asked for, only {} of the {} differ", count, pick + 1, num_poses);
        next = static_cast<int>(farthest - distance.begin());
    }
    return sampling;
}

}  // namespace ndg
