// SPDX-License-Identifier: Apache-2.0
#include "ndg/capture/twin_capture.h"

#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/geometry/rotation.h"

#include <cmath>

namespace ndg {

namespace {

constexpr double degree = M_PI / 180;
constexpr int num_waves = 24;

/// A random function of space with variance one: waves of about one length and all directions.
class SmoothField {
public:
    SmoothField(Random random, double wavelength)
    {
        for (int w = 0; w < num_waves; ++w) {
            Eigen::Vector3d direction(random.normal(), random.normal(), random.normal());
            while (direction.norm() < 1e-3) direction = {random.normal(), random.normal(), random.normal()};
            waves_.col(w) = 2 * M_PI / (wavelength * random.uniform(0.8, 1.25)) * direction.normalized();
            phases_[w] = random.uniform(0, 2 * M_PI);
        }
    }
    double at(const Eigen::Vector3d& x) const
    {
        return std::sqrt(2.0 / num_waves) * (waves_.transpose() * x + phases_).array().cos().sum();
    }

private:
    Eigen::Matrix<double, 3, num_waves> waves_;
    Eigen::Matrix<double, num_waves, 1> phases_;
};

/// A random function of time with variance one, of frequencies up to the largest.
class SlowError {
public:
    SlowError(Random& random, double largest_hertz)
    {
        for (int w = 0; w < num_parts; ++w) {
            hertz_[w] = largest_hertz * random.uniform(0.1, 1);
            phases_[w] = random.uniform(0, 2 * M_PI);
        }
    }
    double at(double seconds) const
    {
        return std::sqrt(2.0 / num_parts) * (2 * M_PI * seconds * hertz_ + phases_).array().cos().sum();
    }

private:
    static constexpr int num_parts = 4;
    Eigen::Matrix<double, num_parts, 1> hertz_, phases_;
};

std::uint64_t frame_key(int sequence_idx, int frame)
{
    return (static_cast<std::uint64_t>(sequence_idx) << 32) + static_cast<std::uint64_t>(frame);
}

void add_noise(Points& vertices, const TwinOptions& options, std::uint64_t seed, std::uint64_t key)
{
    const double each = 1e-3 * options.noise_millimetre / std::sqrt(3.0);
    const double smooth = each * std::sqrt(options.smooth_noise_share);
    const double rough = each * std::sqrt(1 - options.smooth_noise_share);
    Random by_vertex(seed, "twin noise", key);
    for (Eigen::Index i = 0; i < vertices.size(); ++i) vertices.data()[i] += rough * by_vertex.normal();
    if (smooth == 0) return;
    const Points seen = vertices;
    for (int c = 0; c < 3; ++c) {
        const SmoothField field(Random(seed, "twin smooth noise", 3 * key + static_cast<std::uint64_t>(c)),
                                options.smooth_noise_metre);
        for (Eigen::Index v = 0; v < vertices.rows(); ++v) vertices(v, c) += smooth * field.at(seen.row(v).transpose());
    }
}

}  // namespace

void describe(OptionList& list, TwinOptions& options)
{
    list.add("frame-rate", options.frame_rate_hertz, "frames a second; divides the step rate", 1, 1e4);
    list.add("noise", options.noise_millimetre, "root mean square displacement of a vertex by noise, mm", 0, 100);
    list.add("smooth-noise-share", options.smooth_noise_share, "share of its variance that neighbours have alike", 0,
             1);
    list.add("smooth-noise-length", options.smooth_noise_metre, "wavelength of that, m", 1e-3, 10);
    list.add("pose-error", options.pose_error_degrees, "standard deviation of joint angles, degrees", 0, 45);
    list.add("root-error", options.root_error_millimetre, "and of the root's coordinates, mm", 0, 1000);
    list.add("pose-error-rate", options.pose_error_hertz, "largest frequency of these errors, Hz", 1e-3, 1000);
    list.add("heterogeneity", options.heterogeneity, "standard deviation of the logarithm of stiffness over the body",
             0, 2);
    list.add("heterogeneity-length", options.heterogeneity_metre, "wavelength of it, m", 1e-2, 10);
}

Eigen::VectorXd hidden_stiffness(const Template& body_template, const Body& body, const TwinOptions& options,
                                 std::uint64_t seed)
{
    check_options(options);
    const int num_wrap = body_template.num_wrap_vertices();
    const double middle = body.joint_positions(0, 0);
    const SmoothField field(Random(seed, "twin stiffness"), options.heterogeneity_metre);
    Eigen::VectorXd stiffness(num_wrap);
    for (int w = 0; w < num_wrap; ++w) {
        Eigen::Vector3d x = body.volume_vertices.row(2 * num_wrap + w).transpose();
        x[0] = std::abs(x[0] - middle);
        stiffness[w] = std::exp(options.heterogeneity * field.at(x));
    }
    return stiffness;
}

Eigen::VectorXd prism_stiffness(const Template& body_template, const Eigen::VectorXd& wrap_stiffness)
{
    const int num_wrap = body_template.num_wrap_vertices();
    require(wrap_stiffness.size() == num_wrap, "stiffness of {} wrap vertices instead of {}", wrap_stiffness.size(),
            num_wrap);
    Eigen::VectorXd scales = Eigen::VectorXd::Zero(body_template.num_prisms());
    for (Eigen::Index p = 0; p < scales.size(); ++p) {
        for (int a = 0; a < 6; ++a) scales[p] += wrap_stiffness[body_template.prisms(p, a) % num_wrap] / 6;
    }
    return scales;
}

CaptureSequence observed(const CaptureSequence& truth, const TwinOptions& options, std::uint64_t seed, int sequence_idx)
{
    check_options(options);
    require(truth.poses.size() == truth.vertices.size() && !truth.poses.empty(), "{} poses for {} frames",
            truth.poses.size(), truth.vertices.size());
    Random random(seed, "twin poses", static_cast<std::uint64_t>(sequence_idx));
    const std::size_t joints = truth.poses[0].parent_from_joint.size();
    std::vector<SlowError> errors;
    for (std::size_t e = 0; e < 3 * (joints + 1); ++e) errors.emplace_back(random, options.pose_error_hertz);
    CaptureSequence seen = truth;
    for (std::size_t f = 0; f < seen.vertices.size(); ++f) {
        const double time = truth.frame_numbers[f] / truth.frame_rate_hertz;
        const auto error = [&](std::size_t which, double size) {
            return Eigen::Vector3d(size * errors[3 * which].at(time), size * errors[3 * which + 1].at(time),
                                   size * errors[3 * which + 2].at(time));
        };
        for (std::size_t j = 0; j < joints; ++j) {
            seen.poses[f].parent_from_joint[j] *= rotation_of(error(j, degree * options.pose_error_degrees));
        }
        seen.poses[f].root_translation += error(joints, 1e-3 * options.root_error_millimetre);
        add_noise(seen.vertices[f], options, seed, frame_key(sequence_idx, truth.frame_numbers[f]));
    }
    return seen;
}

}  // namespace ndg
