// SPDX-License-Identifier: Apache-2.0
#include "ndg/motion/pose_sampling.h"

#include "ndg/core/error.h"
#include "ndg/motion/rotation.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace ndg {

namespace {

constexpr int block_size = 8;
/// One number of each pose of a block.
using Lane = Eigen::Array<float, block_size, 1>;

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
        blocks_.assign(static_cast<std::size_t>(num_blocks()) * num_joints_ * 4, Lane::Zero());
        for (int i = 0; i < num_poses_; ++i) {
            Lane* block = blocks_.data() + static_cast<std::size_t>(i / block_size) * num_joints_ * 4;
            for (int j = 0; j < num_joints_; ++j) {
                const Eigen::Vector4d& q = quaternions_[static_cast<std::size_t>(i) * num_joints_ + j].coeffs();
                for (int k = 0; k < 4; ++k) block[4 * j + k][i % block_size] = static_cast<float>(q[k]);
            }
        }
    }

    int num_blocks() const { return (num_poses_ + block_size - 1) / block_size; }

    /// Numbers no larger than the distances of a block's poses to a pose, in float32 and without trigonometry: the
    /// angle 4 asin(c / 2) of a chord c is at least the first terms of its series, all of which are positive.
    Lane lower_bounds(int block, int pose) const
    {
        // What float32 may have added to a squared chord, and to the sum.
        constexpr float chord_error = 2e-6F, relative_error = 1e-5F;
        const Lane* p = blocks_.data() + static_cast<std::size_t>(block) * num_joints_ * 4;
        const Eigen::Quaterniond* q = quaternions_.data() + static_cast<std::size_t>(pose) * num_joints_;
        Lane sum = Lane::Zero();
        for (int j = 0; j < num_joints_; ++j, p += 4) {
            const Eigen::Vector4f r = q[j].coeffs().cast<float>();
            const Lane squared =
                (p[0] - r[0]).square() + (p[1] - r[1]).square() + (p[2] - r[2]).square() + (p[3] - r[3]).square();
            const Lane nearer = (squared.min(4.0F - squared) - chord_error).max(0.0F);
            const Lane x = 0.5F * nearer.sqrt(), x2 = 0.25F * nearer;
            sum += x * (4.0F + x2 * (4.0F / 6.0F + x2 * (12.0F / 40.0F + x2 * (60.0F / 336.0F))));
        }
        return sum * (1.0F - relative_error);
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
    std::vector<Lane> blocks_;  ///< num_blocks x num_joints x 4 quaternion coefficients
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
    int next = first_idx;
    while (true) {
        sampling.order.push_back(next);
        // Below that a thread costs more than it does.
#pragma omp parallel for schedule(static) if (num_poses > 20000)
        for (int block = 0; block < table.num_blocks(); ++block) {
            const Lane bounds = table.lower_bounds(block, next);
            const int begin = block * block_size, end = std::min(num_poses, begin + block_size);
            for (int i = begin; i < end; ++i) {
                if (bounds[i - begin] > distance[i]) continue;
                distance[i] = std::min(distance[i], table.distance(i, next, distance[i]));
            }
        }
        const auto farthest = std::max_element(distance.begin(), distance.end());
        sampling.covering_radius.push_back(*farthest);
        const int num_picked = static_cast<int>(sampling.order.size());
        if (num_picked == count) break;
        require_input(*farthest > 0.0, "{} poses were asked for, only {} of the {} differ", count, num_picked,
                      num_poses);
        next = static_cast<int>(farthest - distance.begin());
    }
    return sampling;
}

}  // namespace ndg
