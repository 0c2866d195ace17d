// SPDX-License-Identifier: Apache-2.0
#include "ndg/capture/step_poses.h"

#include "ndg/core/error.h"
#include "ndg/geometry/rotation.h"
#include "ndg/motion/resample_poses.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ndg {

namespace {

/// Of the four around an interval, at `t` of it (Catmull and Rom 1974).
std::array<double, 4> cubic_weights(double t)
{
    return {0.5 * t * ((2 - t) * t - 1), 0.5 * (t * t * (3 * t - 5) + 2), 0.5 * t * ((4 - 3 * t) * t + 1),
            0.5 * t * t * (t - 1)};
}

Pose between(const std::array<const Pose*, 4>& poses, double t)
{
    const std::array<double, 4> weights = cubic_weights(t);
    Pose result = *poses[1];
    result.root_translation.setZero();
    for (std::size_t k = 0; k < 4; ++k) result.root_translation += weights[k] * poses[k]->root_translation;
    for (std::size_t j = 0; j < result.parent_from_joint.size(); ++j) {
        const Eigen::Quaterniond here = to_quaternion(poses[1]->parent_from_joint[j]);
        Eigen::Vector4d sum = Eigen::Vector4d::Zero();
        for (std::size_t k = 0; k < 4; ++k) {
            const Eigen::Quaterniond other = to_quaternion(poses[k]->parent_from_joint[j]);
            sum += (here.dot(other) < 0 ? -weights[k] : weights[k]) * other.coeffs();
        }
        result.parent_from_joint[j] = Eigen::Quaterniond(sum.normalized()).toRotationMatrix();
    }
    return result;
}

}  // namespace

int steps_per_frame(const CaptureSequence& sequence, double step_rate_hertz)
{
    const double steps = step_rate_hertz / sequence.frame_rate_hertz, whole = std::round(steps);
    require_input(whole >= 1 && std::abs(steps - whole) < 1e-9 * steps,
                  "sequence \"{}\" has {} frames a second, which does not divide {} steps a second", sequence.name,
                  sequence.frame_rate_hertz, step_rate_hertz);
    return static_cast<int>(whole);
}

std::vector<Pose> step_poses(const CaptureSequence& sequence, double step_rate_hertz)
{
    require_input(!sequence.poses.empty(), "sequence \"{}\" has no poses, which could drive a simulation",
                  sequence.name);
    const int steps = steps_per_frame(sequence, step_rate_hertz);
    PoseSet clip;
    clip.clip_names = {sequence.name};
    clip.clip_frame_rates = {sequence.frame_rate_hertz};
    clip.poses = sequence.poses;
    clip.clip_idx.assign(sequence.poses.size(), 0);
    clip.frame_idx = sequence.frame_numbers;
    const std::vector<Pose> frames = resample_poses(clip, sequence.frame_rate_hertz).poses;
    const auto last = static_cast<int>(frames.size()) - 1;
    std::vector<Pose> result;
    for (int f = 0; f < last; ++f) {
        std::array<const Pose*, 4> around{};
        for (int k = 0; k < 4; ++k) {
            around[static_cast<std::size_t>(k)] = &frames[static_cast<std::size_t>(std::clamp(f - 1 + k, 0, last))];
        }
        result.push_back(frames[static_cast<std::size_t>(f)]);
        for (int s = 1; s < steps; ++s) result.push_back(between(around, double(s) / steps));
    }
    result.push_back(frames.back());
    return result;
}

}  // namespace ndg
