// SPDX-License-Identifier: Apache-2.0
#include "ndg/motion/keyframes.h"

#include "ndg/core/error.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ndg {

namespace {

using Eigen::Vector3d;

/// Slopes at the keys such that the cubic is monotone wherever the keys are (weighted harmonic mean of the neighbouring
/// differences, zero at extrema), so that it overshoots no key.
std::vector<double> monotone_slopes(const std::vector<double>& x, const std::vector<double>& y)
{
    std::vector<double> slopes(x.size(), 0.0);
    for (std::size_t i = 1; i + 1 < x.size(); ++i) {
        const double before = x[i] - x[i - 1], after = x[i + 1] - x[i];
        const double a = (y[i] - y[i - 1]) / before, b = (y[i + 1] - y[i]) / after;
        if (a * b <= 0.0) continue;
        const double w1 = 2.0 * after + before, w2 = after + 2.0 * before;
        slopes[i] = (w1 + w2) / (w1 / a + w2 / b);
    }
    return slopes;
}

/// The cubic through keys; constant outside.
double evaluate(const std::vector<double>& x, const std::vector<double>& y, double at)
{
    if (at <= x.front()) return y.front();
    if (at >= x.back()) return y.back();
    const auto i = static_cast<std::size_t>(std::upper_bound(x.begin(), x.end(), at) - x.begin()) - 1;
    const std::vector<double> slopes = monotone_slopes(x, y);
    const double h = x[i + 1] - x[i], t = (at - x[i]) / h;
    return y[i] * (1 + 2 * t) * (1 - t) * (1 - t) + h * slopes[i] * t * (1 - t) * (1 - t) +
           y[i + 1] * t * t * (3 - 2 * t) + h * slopes[i + 1] * t * t * (t - 1);
}

/// The keys of one cycle with two more of the neighbouring cycles on either side, so that slopes agree across its ends.
double evaluate_periodic(const KeyframeTrack& track, double period, double time)
{
    const double phase = time - period * std::floor(time / period);
    const auto count = static_cast<long long>(track.times.size());
    std::vector<double> x, y;
    for (long long k = -2; k < count + 2; ++k) {
        const long long cycle = (k < 0 ? k - count + 1 : k) / count;
        const auto key = static_cast<std::size_t>(k - cycle * count);
        x.push_back(track.times[key] + static_cast<double>(cycle) * period);
        y.push_back(track.values[key]);
    }
    return evaluate(x, y, phase);
}

/// Points of the soles: heel and ball fixed to the foot, the tip to the toes. Metres behind the ankle and before the
/// base of the toes.
constexpr double heel_length = 0.04, toe_length = 0.05;

struct SolePoint {
    std::size_t joint;
    Vector3d rest;
};

std::vector<SolePoint> sole_points(const Eigen::Ref<const Points>& joint_positions)
{
    const Skeleton& skeleton = standard_skeleton();
    std::vector<SolePoint> points;
    for (const std::string side : {"left_", "right_"}) {
        const int foot = skeleton.joint(side + "foot"), toes = skeleton.joint(side + "toes");
        const double x = joint_positions(foot, 0), ball = joint_positions(toes, 2);
        points.push_back({std::size_t(foot), {x, 0.0, joint_positions(foot, 2) - heel_length}});
        points.push_back({std::size_t(foot), {joint_positions(toes, 0), 0.0, ball}});
        points.push_back({std::size_t(toes), {joint_positions(toes, 0), 0.0, ball + toe_length}});
    }
    return points;
}

/// Displacement of the root that brings a pose to the ground.
Vector3d ground_translation(Ground ground, const Pose& pose, const Eigen::Ref<const Points>& joint_positions,
                            const std::vector<SolePoint>& soles)
{
    if (ground == Ground::none) return Vector3d::Zero();
    const Skeleton& skeleton = standard_skeleton();
    const auto world_from_rest = forward_kinematics(skeleton, joint_positions, pose);
    Vector3d translation = Vector3d::Zero();
    double lowest = std::numeric_limits<double>::infinity();
    for (const SolePoint& point : soles) lowest = std::min(lowest, (world_from_rest[point.joint] * point.rest).y());
    translation.y() = -lowest;
    if (ground == Ground::both_feet) {
        for (const char* name : {"left_foot", "right_foot"}) {
            const int foot = skeleton.joint(name);
            const Vector3d rest = joint_positions.row(foot).transpose();
            const Vector3d moved = rest - world_from_rest[std::size_t(foot)] * rest;
            translation.x() += 0.5 * moved.x();
            translation.z() += 0.5 * moved.z();
        }
    }
    return translation;
}

}  // namespace

int KeyframeMotion::num_frames() const
{
    return static_cast<int>(std::floor(duration * frame_rate + 1e-6)) + 1;
}

std::vector<double> KeyframeMotion::angles(double time) const
{
    std::vector<double> result = stance;
    for (const KeyframeTrack& track : tracks) {
        result[std::size_t(track.angle)] =
            period > 0.0 ? evaluate_periodic(track, period, time) : evaluate(track.times, track.values, time);
    }
    return result;
}

double KeyframeMotion::height(double time) const
{
    if (lift.times.empty()) return 0;
    return period > 0.0 ? evaluate_periodic(lift, period, time) : evaluate(lift.times, lift.values, time);
}

PoseSet keyframe_poses(const KeyframeMotion& motion, const Eigen::Ref<const Points>& joint_positions,
                       double poses_per_second)
{
    const ClinicalFrames frames(joint_positions);
    const std::vector<SolePoint> soles = sole_points(joint_positions);
    PoseSet poses;
    poses.clip_names = {motion.name};
    poses.clip_frame_rates = {motion.frame_rate};
    const double step = poses_per_second > 0 ? std::max(1.0, motion.frame_rate / poses_per_second) : 1.0;
    for (int k = 0;; ++k) {
        const auto frame = static_cast<int>(std::llround(k * step));
        if (frame >= motion.num_frames()) break;
        Pose pose = frames.pose(motion.angles(frame / motion.frame_rate));
        pose.root_translation = ground_translation(motion.ground, pose, joint_positions, soles);
        pose.root_translation.y() += motion.height(frame / motion.frame_rate);
        poses.poses.push_back(pose);
        poses.clip_idx.push_back(0);
        poses.frame_idx.push_back(frame);
    }
    return poses;
}

}  // namespace ndg
