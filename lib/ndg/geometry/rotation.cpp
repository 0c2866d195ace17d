// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/rotation.h"

#include <algorithm>
#include <cmath>

namespace ndg {

double rotation_angle(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b)
{
    const double chord = std::min((a.coeffs() - b.coeffs()).norm(), (a.coeffs() + b.coeffs()).norm());
    return 4.0 * std::asin(std::min(0.5 * chord, M_SQRT1_2));
}

double rotation_angle(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b)
{
    return rotation_angle(to_quaternion(a), to_quaternion(b));
}

Eigen::Matrix3d about_x(double angle)
{
    return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX()).toRotationMatrix();
}
Eigen::Matrix3d about_y(double angle)
{
    return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()).toRotationMatrix();
}
Eigen::Matrix3d about_z(double angle)
{
    return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

Eigen::Quaterniond to_quaternion(const Eigen::Matrix3d& rotation)
{
    return Eigen::Quaterniond(rotation).normalized();
}

double twist_angle(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& axis)
{
    Eigen::Quaterniond q = to_quaternion(rotation);
    if (q.w() < 0) q.coeffs() *= -1.0;
    return 2.0 * std::atan2(q.vec().dot(axis), q.w());
}

Eigen::Matrix3d minimal_rotation(const Eigen::Vector3d& from, const Eigen::Vector3d& to)
{
    const Eigen::Vector3d a = from.normalized(), b = to.normalized();
    if (a.dot(b) > -1.0 + 1e-12) return Eigen::Quaterniond::FromTwoVectors(a, b).toRotationMatrix();
    int smallest = 0;
    a.cwiseAbs().minCoeff(&smallest);
    const Eigen::Vector3d axis = a.cross(Eigen::Vector3d::Unit(smallest)).normalized();
    return Eigen::AngleAxisd(M_PI, axis).toRotationMatrix();
}

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& rotation)
{
    Eigen::Quaterniond q = to_quaternion(rotation);
    if (q.w() < 0) q.coeffs() *= -1.0;
    const double sine = q.vec().norm();
    // 2 atan2(s, w) / s tends to 2 / w.
    const double factor = sine > 1e-12 ? 2.0 * std::atan2(sine, q.w()) / sine : 2.0 / q.w();
    return factor * q.vec();
}

Eigen::Matrix3d rotation_of(const Eigen::Vector3d& rotation_vector)
{
    const double angle = rotation_vector.norm();
    if (angle < 1e-12) {
        const Eigen::Vector3d half = 0.5 * rotation_vector;
        return Eigen::Quaterniond(1.0, half.x(), half.y(), half.z()).normalized().toRotationMatrix();
    }
    return Eigen::AngleAxisd(angle, rotation_vector / angle).toRotationMatrix();
}

}  // namespace ndg
