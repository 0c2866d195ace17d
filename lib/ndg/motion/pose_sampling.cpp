// SPDX-License-Identifier: Apache-2.0
#include "ndg/motion/pose_sampling.h"

#include "ndg/core/error.h"
#include "ndg/geometry/rotation.h"

#include <algorithm>
#include <limits>

namespace ndg {

namespace {

constexpr int block_size = 8;
/// For fewer blocks waking a thread costs more than it does.
constexpr int parallel_blocks = 1000;
/// One number of each pose of a block.
using Lane = Eigen::Array<float, block_size, 1>;

/// A float no smaller than a double.
float rounded_up(double value)
{
    return static_cast<float>(value) * (1.0F + 1e-6F);
}

/// Joint rotations as float32 quaternions, eight poses side by side.
class PoseBlocks {
public:
    PoseBlocks(int capacity, int num_joints)
        : num_joints_(num_joints), lanes_(num_blocks(capacity) * 4 * num_joints, Lane::Zero())
    {
    }

    static std::size_t num_blocks(int num_poses)
    {
        return (static_cast<std::size_t>(num_poses) + block_size - 1) / block_size;
    }

    /// `quaternion`: num_joints x 4.
    void set(int pose, const float* quaternion)
    {
        Lane* block = lanes_.data() + static_cast<std::size_t>(pose / block_size) * 4 * num_joints_;
        for (int k = 0; k < 4 * num_joints_; ++k) block[k][pose % block_size] = quaternion[k];
    }

    void get(int pose, float* quaternion) const
    {
        const Lane* block = lanes_.data() + static_cast<std::size_t>(pose / block_size) * 4 * num_joints_;
        for (int k = 0; k < 4 * num_joints_; ++k) quaternion[k] = block[k][pose % block_size];
    }

    /// Numbers no larger than the distances of a block's poses to the pose q, in float32 and without trigonometry: the
    /// angle 4 asin(c / 2) of a chord c is at least the first terms of its series, all of which are positive. Stops
    /// early where all are above `limits`.
    Lane lower_bounds(int block, const float* q, const Lane& limits) const
    {
        // What float32 may have added to a squared chord, and to the sum.
        constexpr float chord_error = 2e-6F;
        const float relative_error = 2e-6F + 1e-7F * static_cast<float>(num_joints_);
        constexpr int stride = 4;  // joints between two looks at the limits
        const Lane* p = lanes_.data() + static_cast<std::size_t>(block) * 4 * num_joints_;
        Lane sum = Lane::Zero();
        for (int begin = 0; begin < num_joints_; begin += stride) {
            for (int j = begin; j < std::min(num_joints_, begin + stride); ++j, p += 4, q += 4) {
                const Lane cosine = (p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3]).abs();
                const Lane squared = (2.0F - chord_error - 2.0F * cosine).max(0.0F);
                const Lane x2 = 0.25F * squared;
                sum += x2.sqrt() * (4.0F + x2 * (4.0F / 6.0F + x2 * (12.0F / 40.0F + x2 * (60.0F / 336.0F))));
            }
            if ((sum * (1.0F - relative_error) - limits).minCoeff() > 0.0F) break;
        }
        return sum * (1.0F - relative_error);
    }

private:
    int num_joints_;
    std::vector<Lane> lanes_;  ///< num_blocks x num_joints x 4 quaternion coefficients
};

/// Distance of every pose to the nearest of the picked ones. Poses come in blocks of eight, each with the largest
/// distance among them.
class NearestPicks {
public:
    NearestPicks(const std::vector<Pose>& poses, int num_picks)
        : num_poses_(static_cast<int>(poses.size())),
          num_joints_(static_cast<int>(poses.front().parent_from_joint.size())),
          num_blocks_(static_cast<int>(PoseBlocks::num_blocks(num_poses_))),
          screening_joints_(joints_by_spread(poses)),
          quaternions_(poses.size() * num_joints_),
          candidates_(num_poses_, static_cast<int>(screening_joints_.size())),
          picks_(num_picks, static_cast<int>(screening_joints_.size())),
          distance_(poses.size(), std::numeric_limits<double>::infinity()),
          // Lanes behind the last pose are at distance 0 already.
          reach_(num_blocks_, Lane::Zero()),
          nearest_(static_cast<std::size_t>(num_blocks_) * block_size, 0),
          farthest_(num_blocks_, std::numeric_limits<double>::infinity()),
          pick_bounds_(PoseBlocks::num_blocks(num_picks), Lane::Zero())
    {
#pragma omp parallel for schedule(static) if (num_blocks_ > parallel_blocks)
        for (int block = 0; block < num_blocks_; ++block) {
            std::vector<float> single(4 * screening_joints_.size());
            for (int i = block * block_size; i < std::min(num_poses_, (block + 1) * block_size); ++i) {
                Eigen::Quaterniond* q = quaternions_.data() + static_cast<std::size_t>(i) * num_joints_;
                for (int j = 0; j < num_joints_; ++j) q[j] = to_quaternion(poses[i].parent_from_joint[j]);
                for (std::size_t k = 0; k < screening_joints_.size(); ++k) {
                    const Eigen::Vector4f coefficients = q[screening_joints_[k]].coeffs().cast<float>();
                    std::copy_n(coefficients.data(), 4, single.data() + 4 * k);
                }
                candidates_.set(i, single.data());
                reach_[block][i % block_size] = std::numeric_limits<float>::infinity();
            }
        }
    }

    /// Takes one more pose among the picked: any at first, then the farthest.
    void pick(int pose)
    {
        std::vector<float> q(4 * screening_joints_.size());
        candidates_.get(pose, q.data());
        const int num_pick_blocks = static_cast<int>(PoseBlocks::num_blocks(num_picks_));
        // Nothing lies farther than this from its pick, so that a pick at twice that distance matters to nobody.
        const Lane reach = Lane::Constant(2.0F * rounded_up(distance_[pose]));
        for (int block = 0; block < num_pick_blocks; ++block) {
            pick_bounds_[block] = picks_.lower_bounds(block, q.data(), reach);
        }
        active_.clear();
        for (int block = 0; block < num_blocks_; ++block) {
            if (may_come_nearer(block)) active_.push_back(block);
        }
        const int num_active = static_cast<int>(active_.size());
#pragma omp parallel for schedule(dynamic, 64) if (num_active > parallel_blocks)
        for (int k = 0; k < num_active; ++k) update(active_[k], pose, q.data());
        picks_.set(num_picks_, q.data());
        ++num_picks_;
    }

    /// The pose farthest from all picked ones, the first of several.
    int farthest() const
    {
        const auto block = std::max_element(farthest_.begin(), farthest_.end()) - farthest_.begin();
        const auto begin = distance_.begin() + block * block_size;
        const auto end = distance_.begin() + std::min<std::ptrdiff_t>(num_poses_, (block + 1) * block_size);
        return static_cast<int>(std::max_element(begin, end) - distance_.begin());
    }

    double distance(int pose) const
    {
        return distance_[pose];
    }

private:
    /// Joints in descending order of how much they differ among the poses, so that a sum passes its limit early; joints
    /// that never move are left out, for they add exactly 0.
    static std::vector<int> joints_by_spread(const std::vector<Pose>& poses)
    {
        const std::size_t num_joints = poses.front().parent_from_joint.size();
        std::vector<double> spread(num_joints, 0.0);
        std::vector<int> joints;
        for (const Pose& pose : poses) {
            for (std::size_t j = 0; j < num_joints; ++j) {
                spread[j] += (pose.parent_from_joint[j] - poses.front().parent_from_joint[j]).norm();
            }
        }
        for (std::size_t j = 0; j < num_joints; ++j) {
            if (spread[j] > 0.0) joints.push_back(static_cast<int>(j));
        }
        std::stable_sort(joints.begin(), joints.end(), [&](int a, int b) { return spread[a] > spread[b]; });
        return joints;
    }

    /// False where the triangle inequality shows that the new pick is no nearer to any pose of the block than the
    /// nearest pick so far: it is at least twice as far from that one as the pose is.
    bool may_come_nearer(int block) const
    {
        if (num_picks_ == 0) return true;
        const float* bounds = pick_bounds_.front().data();
        const int* nearest = nearest_.data() + static_cast<std::size_t>(block) * block_size;
        bool result = false;
        for (int k = 0; k < block_size; ++k) result |= bounds[nearest[k]] < 2.0F * reach_[block][k];
        return result;
    }

    void update(int block, int pose, const float* q)
    {
        const Lane bounds = candidates_.lower_bounds(block, q, reach_[block]);
        if ((bounds - reach_[block]).minCoeff() > 0.0F) return;
        const int begin = block * block_size, end = std::min(num_poses_, begin + block_size);
        for (int i = begin; i < end; ++i) {
            if (bounds[i - begin] > reach_[block][i - begin]) continue;
            const double exact = exact_distance(i, pose);
            if (exact >= distance_[i]) continue;
            distance_[i] = exact;
            reach_[block][i - begin] = rounded_up(exact);
            nearest_[i] = num_picks_;
        }
        farthest_[block] = *std::max_element(distance_.begin() + begin, distance_.begin() + end);
    }

    /// Summed as in pose_distance, so that it is the same to the last bit.
    double exact_distance(int a, int b) const
    {
        const Eigen::Quaterniond* p = quaternions_.data() + static_cast<std::size_t>(a) * num_joints_;
        const Eigen::Quaterniond* q = quaternions_.data() + static_cast<std::size_t>(b) * num_joints_;
        double sum = 0.0;
        for (int j = 0; j < num_joints_; ++j) sum += rotation_angle(p[j], q[j]);
        return sum;
    }

    int num_poses_, num_joints_, num_blocks_, num_picks_ = 0;
    std::vector<int> screening_joints_;
    std::vector<Eigen::Quaterniond> quaternions_;  ///< num_poses x num_joints
    PoseBlocks candidates_, picks_;
    std::vector<double> distance_;   ///< to the nearest pick
    std::vector<Lane> reach_;        ///< the same by block, rounded up
    std::vector<int> nearest_;       ///< which pick that is
    std::vector<double> farthest_;   ///< per block, largest distance
    std::vector<Lane> pick_bounds_;  ///< lower bounds of the distances of the newest pick to the earlier ones
    std::vector<int> active_;        ///< blocks that the newest pick may come nearer to
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

std::vector<Pose> with_marked_joints(std::vector<Pose> poses, const std::vector<int>& marked)
{
    for (Pose& pose : poses) {
        require_input(pose.parent_from_joint.size() == marked.size(), "a pose has {} joints, {} were marked or not",
                      pose.parent_from_joint.size(), marked.size());
        for (std::size_t j = 1; j < marked.size(); ++j)
            if (!marked[j]) pose.parent_from_joint[j].setIdentity();
    }
    return poses;
}

PoseSampling farthest_point_sampling(const std::vector<Pose>& poses, int count, const std::vector<int>& first)
{
    const int num_poses = static_cast<int>(poses.size());
    require_input(count >= 1 && count <= num_poses, "{} poses were asked for, there are {}", count, num_poses);
    const int num_first = static_cast<int>(first.size());
    require_input(num_first >= 1 && num_first <= count, "{} of {} poses were given to begin with", num_first, count);
    for (const int idx : first)
        require_input(idx >= 0 && idx < num_poses, "the first pose is {}, there are {}", idx, num_poses);
    NearestPicks nearest(poses, count);
    PoseSampling sampling;
    int next = first.front();
    while (true) {
        nearest.pick(next);
        sampling.order.push_back(next);
        const int farthest = nearest.farthest();
        const double radius = nearest.distance(farthest);
        sampling.covering_radius.push_back(radius);
        const int num_picked = static_cast<int>(sampling.order.size());
        if (num_picked == count) break;
        if (num_picked < num_first) {
            next = first[num_picked];
            continue;
        }
        require_input(radius > 0.0, "{} poses were asked for, only {} of the {} differ", count, num_picked, num_poses);
        next = farthest;
    }
    return sampling;
}

}  // namespace ndg
