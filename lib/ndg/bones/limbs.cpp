// SPDX-License-Identifier: Apache-2.0
#include "ndg/bones/limbs.h"

#include "ndg/geometry/rotation.h"

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>

namespace ndg {

namespace {

constexpr double degree = M_PI / 180.0;

/// The point farthest along a direction.
Eigen::Vector3d farthest(const Eigen::Ref<const Points>& points, const Eigen::Vector3d& direction)
{
    Eigen::Index best = 0;
    (points * direction).maxCoeff(&best);
    return points.row(best).transpose();
}

/// Mean of the points within `reach` of the farthest one along a direction.
Eigen::Vector3d end_of(const Eigen::Ref<const Points>& points, const Eigen::Vector3d& direction, double reach)
{
    const Eigen::VectorXd along = points * direction;
    const double last = along.maxCoeff() - reach;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int count = 0;
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        if (along[i] < last) continue;
        sum += points.row(i).transpose();
        ++count;
    }
    return sum / count;
}

Eigen::Isometry3d turn_about(const Eigen::Vector3d& point, const Eigen::Matrix3d& rotation)
{
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    motion.linear() = rotation;
    motion.translation() = point - rotation * point;
    return motion;
}

}  // namespace

RibCage::RibCage(const Eigen::Ref<const Points>& ribs)
{
    // a x^2 + b y^2 + c z^2 + d y + e z = 1
    Eigen::MatrixXd system(ribs.rows(), 5);
    system.leftCols<3>() = ribs.cwiseProduct(ribs);
    system.rightCols<2>() = ribs.rightCols<2>();
    const Eigen::VectorXd solution =
        (system.transpose() * system).ldlt().solve(system.transpose() * Eigen::VectorXd::Ones(ribs.rows()));
    const Eigen::Vector3d squares = solution.head<3>();
    centre_ = {0.0, -0.5 * solution[3] / squares[1], -0.5 * solution[4] / squares[2]};
    const double level = 1.0 + squares.dot(centre_.cwiseProduct(centre_));
    if ((squares.array() / level > 0.0).all()) {
        half_axes_ = (level / squares.array()).sqrt();
        return;
    }
    // Ribs of no such form, as of badly placed ones: the ellipsoid in their box.
    const Eigen::Vector3d low = ribs.colwise().minCoeff(), high = ribs.colwise().maxCoeff();
    centre_ = 0.5 * (low + high);
    half_axes_ = 0.5 * (high - low);
}

double RibCage::height(const Eigen::Vector3d& point, Eigen::Vector3d* gradient) const
{
    // (q - 1) q / |grad q^2 / 2| with q = |x / a|: the distance along the gradient to first order.
    const Eigen::Vector3d scaled = (point - centre_).cwiseQuotient(half_axes_),
                          normal = scaled.cwiseQuotient(half_axes_);
    const double q = scaled.norm(), slope = normal.norm() / q;
    if (gradient != nullptr) *gradient = normal / normal.norm();
    return (q - 1.0) / slope;
}

double scapula_upward_turn(double arm_elevation)
{
    // Bone pins, scapular plane, 30 to 120 degrees (Ludewig et al. 2009); beyond at 0.3 a degree, as from 90 on; below
    // at 0.35, as from 30 on.
    constexpr std::array<std::array<double, 2>, 6> table = {
        {{0, 5.0}, {30, 15.5}, {60, 26.0}, {90, 34.4}, {120, 43.5}, {180, 61.5}}};
    const double elevation = std::clamp(arm_elevation / degree, table.front()[0], table.back()[0]);
    std::size_t i = 1;
    while (i + 1 < table.size() && table[i][0] < elevation) ++i;
    const double share = (elevation - table[i - 1][0]) / (table[i][0] - table[i - 1][0]);
    return degree * (table[i - 1][1] + share * (table[i][1] - table[i - 1][1]));
}

ShoulderMotion::ShoulderMotion(const Eigen::Vector3d& joint, const Eigen::Vector3d& elbow,
                               const Eigen::Vector3d& sternoclavicular, const Eigen::Ref<const Points>& clavicle,
                               const Eigen::Ref<const Points>& scapula, const RibCage& cage)
    : joint_(joint), sternoclavicular_(sternoclavicular), arm_(elbow - joint), cage_(&cage)
{
    const double side = joint.x() >= 0.0 ? 1.0 : -1.0;
    const Eigen::Vector3d out = side * Eigen::Vector3d::UnitX(), up = Eigen::Vector3d::UnitY();
    acromioclavicular_ = end_of(clavicle, out, 0.006);
    const Eigen::Vector3d inferior = farthest(scapula, -up),
                          superior = farthest(scapula, (up - 2.0 * out).normalized());
    const Eigen::Vector3d root = farthest(scapula, -out);
    corners_ = {inferior, superior, root};
    for (const Eigen::Vector3d& corner : corners_) corner_heights_.push_back(cage.height(corner));
    plate_side_ = (joint - 0.5 * (inferior + superior)).normalized();
    plate_normal_ = (superior - inferior).cross(plate_side_).normalized();
    const Eigen::Vector3d middle = scapula.colwise().mean();
    Eigen::Vector3d outwards;
    cage.height(middle, &outwards);
    if (plate_normal_.dot(outwards) < 0.0) plate_normal_ = -plate_normal_;
    // Upwards turns the glenoid up: about +-normal, whichever lifts the side of the glenoid.
    up_sign_ = plate_normal_.cross(plate_side_).dot(up) >= 0.0 ? 1.0 : -1.0;
    constexpr double towards_clavicle = 0.4;  // the glenoid's gap counts more than the one at the acromion
    pivot_ = joint_ + towards_clavicle * (acromioclavicular_ - joint_);
    rest_elevation_ = std::acos(std::clamp(-arm_.normalized().y(), -1.0, 1.0));
}

ShoulderMotion::Bones ShoulderMotion::bones(const Eigen::Isometry3d& thorax, const Eigen::Isometry3d& clavicle,
                                            const Eigen::Isometry3d& upper_arm) const
{
    // Everything in the frame of the thorax, which is the world's at rest.
    const Eigen::Isometry3d from_world = thorax.inverse();
    const Eigen::Isometry3d carried = from_world * clavicle;
    const Eigen::Vector3d arm = (from_world * upper_arm).linear() * arm_;
    const double elevation = std::acos(std::clamp(-arm.normalized().y(), -1.0, 1.0));
    const double turn = scapula_upward_turn(elevation) - scapula_upward_turn(rest_elevation_);

    const Eigen::Vector3d pivot = carried * pivot_;
    Eigen::Matrix3d rotation = rotation_of(up_sign_ * turn * plate_normal_);
    // Gliding: turns about the axes in the plate, until its corners are as high over the ribs as at rest.
    constexpr int iterations = 4;
    constexpr double stiffness = 0.02;  // m a radian: what turning costs against what heights cost
    const Eigen::Vector3d along = plate_normal_.cross(plate_side_);
    Eigen::Vector2d bent = Eigen::Vector2d::Zero();
    for (int iteration = 0; iteration < iterations; ++iteration) {
        const Eigen::Vector3d axes[2] = {rotation * plate_side_, rotation * along};
        Eigen::Matrix2d hessian = stiffness * stiffness * Eigen::Matrix2d::Identity();
        Eigen::Vector2d slope = stiffness * stiffness * bent;
        for (std::size_t c = 0; c < corners_.size(); ++c) {
            const Eigen::Vector3d arm_of_corner = rotation * (corners_[c] - pivot_);
            Eigen::Vector3d gradient;
            const double residual = cage_->height(pivot + arm_of_corner, &gradient) - corner_heights_[c];
            Eigen::Vector2d change;
            for (int a = 0; a < 2; ++a) change[a] = gradient.dot(axes[a].cross(arm_of_corner));
            hessian += change * change.transpose();
            slope += residual * change;
        }
        Eigen::Vector2d step = -hessian.ldlt().solve(slope);
        step = step.cwiseMax(-0.3).cwiseMin(0.3);
        bent += step;
        rotation = rotation_of(step[0] * axes[0] + step[1] * axes[1]) * rotation;
    }
    Bones bones;
    bones.scapula = Eigen::Isometry3d::Identity();
    bones.scapula.linear() = rotation;
    bones.scapula.translation() = pivot - rotation * pivot_;

    const Eigen::Vector3d inner = carried * sternoclavicular_;
    bones.clavicle = turn_about(inner, minimal_rotation(carried * acromioclavicular_ - inner,
                                                        bones.scapula * acromioclavicular_ - inner)) *
                     carried;
    bones.scapula = thorax * bones.scapula;
    bones.clavicle = thorax * bones.clavicle;
    return bones;
}

ForearmMotion::ForearmMotion(const Eigen::Vector3d& elbow, const Eigen::Vector3d& wrist,
                             const Eigen::Ref<const Points>& radius, const Eigen::Ref<const Points>& ulna)
    : elbow_(elbow), wrist_(wrist)
{
    const Eigen::Vector3d axis = (wrist - elbow).normalized();
    constexpr double end = 0.012;
    radial_head_ = end_of(radius, -axis, end);
    ulnar_head_ = end_of(ulna, axis, end);
}

ForearmMotion::Bones ForearmMotion::bones(const Eigen::Isometry3d& forearm, const Eigen::Isometry3d& hand) const
{
    const Eigen::Matrix3d hand_in_forearm = forearm.linear().transpose() * hand.linear();
    const Eigen::Vector3d axis = (wrist_ - radial_head_).normalized();
    const double turn = twist_angle(hand_in_forearm, (wrist_ - elbow_).normalized());
    const Eigen::Isometry3d about_axis = turn_about(radial_head_, rotation_of(turn * axis));
    const Eigen::Vector3d ulnar_head = about_axis * ulnar_head_;
    Bones bones;
    bones.radius = forearm * about_axis;
    bones.ulna = forearm * turn_about(elbow_, minimal_rotation(ulnar_head_ - elbow_, ulnar_head - elbow_));
    return bones;
}

}  // namespace ndg
