// SPDX-License-Identifier: Apache-2.0
#include "ndg/bones/knee.h"

#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/rotation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ndg {

namespace {

constexpr double degree = M_PI / 180.0;
/// Flexions at which shifts are measured.
constexpr int first_step = -1, num_steps = 17;
constexpr double step_angle = 10.0 * degree;

/// Kneecap in the femur every 10 degrees of flexion from 0: forward and up (mm), and its turn (degrees). Walker et al.
/// 1988 as in the model of Rajagopal et al. 2016 (Rajagopal2016.osim, patellofemoral joint), whose knee has its centre
/// 48 mm behind and 23 mm above the kneecap's at 0 degrees.
struct PatellaPlace {
    double forward, up, turn;
};
constexpr std::array<PatellaPlace, 13> patella_path = {{{52.4, -10.8, 0.0},
                                                        {48.8, -19.0, 0.0},
                                                        {43.7, -26.3, 6.0},
                                                        {37.1, -32.2, 14.5},
                                                        {29.6, -36.7, 23.7},
                                                        {21.6, -39.5, 33.2},
                                                        {13.6, -40.8, 42.8},
                                                        {5.7, -40.4, 52.6},
                                                        {-1.9, -38.4, 62.5},
                                                        {-8.8, -34.9, 72.4},
                                                        {-14.8, -30.1, 82.4},
                                                        {-19.6, -24.5, 92.4},
                                                        {-22.7, -18.7, 102.3}}};
constexpr double model_distance = 0.053;  // m, from the knee's centre to the kneecap's

PatellaPlace patella_place(double flexion)
{
    // Beyond the table the last step goes on; overstretched, the kneecap stays.
    const double s = std::max(flexion / (10.0 * degree), 0.0);
    const std::size_t i = std::min(std::size_t(s), patella_path.size() - 2);
    const double share = s - double(i);
    const PatellaPlace &a = patella_path[i], &b = patella_path[i + 1], &rest = patella_path.front();
    const auto at = [&](double from, double to, double start) { return from + share * (to - from) - start; };
    return {1e-3 * at(a.forward, b.forward, rest.forward), 1e-3 * at(a.up, b.up, rest.up),
            degree * at(a.turn, b.turn, rest.turn)};
}

double interpolated(const std::vector<double>& values, double flexion)
{
    const double s = std::clamp(flexion / step_angle - first_step, 0.0, num_steps - 1.0);
    const int i = std::min(int(s), num_steps - 2);
    return values[i] + (s - i) * (values[i + 1] - values[i]);
}

/// Rows of the vertices that lie within `reach` of a point.
Points near_points(const Eigen::Ref<const Points>& points, const Eigen::Vector3d& centre, double reach)
{
    Points near(points.rows(), 3);
    Eigen::Index count = 0;
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        if ((points.row(i).transpose() - centre).norm() < reach) near.row(count++) = points.row(i);
    near.conservativeResize(count, 3);
    return near;
}

Eigen::Isometry3d translated(const Eigen::Vector3d& by)
{
    return Eigen::Isometry3d(Eigen::Translation3d(by));
}

}  // namespace

double surface_gap(const TriangleTree& fixed, const Eigen::Ref<const Points>& moving, const Eigen::Isometry3d& motion)
{
    double gap = std::numeric_limits<double>::infinity();
    for (Eigen::Index i = 0; i < moving.rows(); ++i)
        gap = std::min(gap, fixed.signed_distance(motion * moving.row(i).transpose()));
    return gap;
}

KneeMotion::KneeMotion(const Eigen::Vector3d& hip, const Eigen::Vector3d& knee,
                       const Eigen::Ref<const Points>& femur_vertices,
                       const Eigen::Ref<const Triangles>& femur_triangles, const Eigen::Ref<const Points>& tibia,
                       const Eigen::Ref<const Points>& patella)
    : knee_(knee), up_((hip - knee).normalized()), patella_centre_(patella.colwise().mean().transpose())
{
    lateral_ = (Eigen::Vector3d::UnitX() - up_.x() * up_).normalized();
    forward_ = lateral_.cross(up_);
    scale_ = (patella_centre_ - knee_).norm() / model_distance;

    const TriangleTree femur(femur_vertices, femur_triangles);
    constexpr double reach = 0.08, most = 0.025;
    constexpr int iterations = 8;
    const Points plateau = near_points(tibia, knee_, reach);
    // Shift along `path` at which the gap is that of rest.
    const auto keep_gap = [&](const Points& moving, double start, const auto& motion_at) {
        const double rest_gap = surface_gap(femur, moving, Eigen::Isometry3d::Identity());
        double shift = start;
        for (int i = 0; i < iterations; ++i) {
            const double missing = rest_gap - surface_gap(femur, moving, motion_at(shift));
            if (std::abs(missing) < 1e-5) break;
            shift = std::clamp(shift + missing, -most, most);
        }
        return shift;
    };
    shank_shifts_.assign(num_steps, 0.0);
    patella_shifts_.assign(num_steps, 0.0);
    const auto measure = [&](int step, int neighbour) {
        const double angle = (step + first_step) * step_angle;
        const Eigen::Isometry3d shin = shin_in_femur(angle);
        if (plateau.rows() > 0)
            shank_shifts_[step] = keep_gap(plateau, shank_shifts_[neighbour],
                                           [&](double shift) { return shin * translated(-shift * up_); });
        patella_shifts_[step] = keep_gap(patella, patella_shifts_[neighbour],
                                         [&](double shift) { return patella_in_femur(angle, shift); });
    };
    // From the rest pose, which has no shift, outwards.
    for (int step = -first_step + 1; step < num_steps; ++step) measure(step, step - 1);
    for (int step = -first_step - 1; step >= 0; --step) measure(step, step + 1);
}

double KneeMotion::flexion(const Eigen::Isometry3d& thigh, const Eigen::Isometry3d& shin) const
{
    return twist_angle(thigh.linear().transpose() * shin.linear(), lateral_);
}

Eigen::Isometry3d KneeMotion::shin_in_femur(double flexion) const
{
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    motion.linear() = rotation_of(flexion * lateral_);
    motion.translation() = knee_ - motion.linear() * knee_;
    return motion;
}

Eigen::Isometry3d KneeMotion::patella_in_femur(double flexion, double shift) const
{
    const PatellaPlace place = patella_place(flexion);
    const Eigen::Vector3d moved =
        patella_centre_ + scale_ * (place.forward * forward_ + place.up * up_);
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    motion.linear() = rotation_of(place.turn * lateral_);
    const Eigen::Vector3d away = motion.linear() * forward_;
    motion.translation() = moved + shift * away - motion.linear() * patella_centre_;
    return motion;
}

KneeMotion::Bones KneeMotion::bones(const Eigen::Isometry3d& thigh, const Eigen::Isometry3d& shin) const
{
    const double angle = flexion(thigh, shin);
    Bones bones;
    bones.shank = shin * translated(-interpolated(shank_shifts_, angle) * up_);
    bones.patella = thigh * patella_in_femur(angle, interpolated(patella_shifts_, angle));
    return bones;
}

}  // namespace ndg
