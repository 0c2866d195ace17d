// SPDX-License-Identifier: Apache-2.0
#include "ndg/bones/knee.h"

#include "ndg/geometry/rotation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ndg {

namespace {

constexpr double degree = M_PI / 180.0;
/// Lower pole of the kneecap in the femur every 10 degrees of flexion from 0: forward and up (mm), and the kneecap's
/// turn (degrees). Walker et al. 1988 as in the model of Rajagopal et al. 2016 (Rajagopal2016.osim, patellofemoral
/// joint). Its frame has the origin at the lower pole, 26.4 mm below and 1.8 mm behind the centre of mass, which at 0
/// degrees lies 50 mm in front of the knee's centre.
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
constexpr double centre_forward = 0.0018, centre_up = 0.0264;  // m, from the pole, at 0 degrees
constexpr double model_distance = 0.050;                       // m, from the knee's centre to the kneecap's

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

}  // namespace

KneeMotion::KneeMotion(const Eigen::Vector3d& hip, const Eigen::Vector3d& knee,
                       const Eigen::Ref<const Points>& femur_vertices,
                       const Eigen::Ref<const Triangles>& femur_triangles, const Eigen::Ref<const Points>& tibia,
                       const Eigen::Ref<const Points>& patella)
    : knee_(knee), up_((hip - knee).normalized()), patella_centre_(patella.colwise().mean().transpose())
{
    constexpr double femur_reach = 0.07, tibia_reach = 0.06, margin = 0.02, spacing = 0.0025;
    lateral_ = (Eigen::Vector3d::UnitX() - up_.x() * up_).normalized();
    forward_ = lateral_.cross(up_);
    scale_ = (patella_centre_ - knee_).norm() / model_distance;
    femur_distance_ = signed_distance_grid(
        grid_around(near_points(femur_vertices, knee_, femur_reach), margin, spacing), femur_vertices, femur_triangles);
    tibia_ = facing(near_points(tibia, knee_, tibia_reach));
    patella_ = facing(patella);
}

KneeMotion::Facing KneeMotion::facing(const Points& vertices) const
{
    return {vertices, gap(vertices, Eigen::Isometry3d::Identity())};
}

double KneeMotion::gap(const Points& vertices, const Eigen::Isometry3d& femur_from_rest) const
{
    return vertices.rows() > 0 ? distances(vertices, femur_from_rest).minCoeff()
                               : std::numeric_limits<double>::infinity();
}

Eigen::VectorXd KneeMotion::distances(const Points& vertices, const Eigen::Isometry3d& femur_from_rest) const
{
    Eigen::VectorXd result(vertices.rows());
    for (Eigen::Index i = 0; i < vertices.rows(); ++i)
        result[i] = femur_distance_.at(femur_from_rest * vertices.row(i).transpose());
    return result;
}

double KneeMotion::shift(const Facing& bone, Eigen::Isometry3d femur_from_rest, const Eigen::Vector3d& away) const
{
    if (bone.vertices.rows() == 0) return 0.0;
    constexpr int iterations = 6;
    constexpr double most = 0.025;
    constexpr double least_slope = 0.3;  // of the gap along the shift, where the bones meet aslant
    // Vertices farther than the nearest one by two shifts cannot become the nearest.
    constexpr double usual = 0.010;  // m, a shift beyond which all are looked at again
    const Eigen::VectorXd unshifted = distances(bone.vertices, femur_from_rest);
    double least = unshifted.minCoeff();
    Points near(bone.vertices.rows(), 3);
    Eigen::Index count = 0;
    for (Eigen::Index i = 0; i < near.rows(); ++i)
        if (unshifted[i] <= least + 2.0 * usual) near.row(count++) = bone.vertices.row(i);
    near.conservativeResize(count, 3);
    double total = 0.0, slope = 1.0;
    for (int i = 0; i < iterations; ++i) {
        const double step = std::clamp(total + (bone.rest_gap - least) / slope, -most, most) - total;
        if (std::abs(step) < 1e-6) break;
        femur_from_rest.pretranslate(step * away);
        total += step;
        const double before = least;
        least = gap(std::abs(total) > usual ? bone.vertices : near, femur_from_rest);
        slope = std::clamp((least - before) / step, least_slope, 1.0);
    }
    return total;
}

double KneeMotion::flexion(const Eigen::Isometry3d& thigh, const Eigen::Isometry3d& shin) const
{
    return twist_angle(thigh.linear().transpose() * shin.linear(), lateral_);
}

KneeMotion::Bones KneeMotion::bones(const Eigen::Isometry3d& thigh, const Eigen::Isometry3d& shin) const
{
    Bones bones;
    const Eigen::Isometry3d shin_in_femur = thigh.inverse() * shin;
    const Eigen::Vector3d down = -(shin_in_femur.linear() * up_);
    bones.shank = thigh * Eigen::Translation3d(shift(tibia_, shin_in_femur, down) * down) * shin_in_femur;

    const PatellaPlace place = patella_place(flexion(thigh, shin));
    Eigen::Isometry3d patella = Eigen::Isometry3d::Identity();
    patella.linear() = rotation_of(place.turn * lateral_);
    const Eigen::Vector3d pole = patella_centre_ - scale_ * (centre_forward * forward_ + centre_up * up_);
    patella.translation() = pole + scale_ * (place.forward * forward_ + place.up * up_) - patella.linear() * pole;
    const Eigen::Vector3d away = patella.linear() * forward_;
    bones.patella = thigh * Eigen::Translation3d(shift(patella_, patella, away) * away) * patella;
    return bones;
}

}  // namespace ndg
