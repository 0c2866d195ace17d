// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"

namespace ndg {

/// Angle between two rotations in radians, [0, pi]. From the chord of the unit quaternions, 4 asin(|q - p| / 2) with
/// signs aligned, which keeps full precision for small and large angles alike.
double rotation_angle(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b);
double rotation_angle(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b);

/// Rotation by `angle` radians about a coordinate axis.
Eigen::Matrix3d about_x(double angle);
Eigen::Matrix3d about_y(double angle);
Eigen::Matrix3d about_z(double angle);

/// Unit quaternion of a rotation matrix.
Eigen::Quaterniond to_quaternion(const Eigen::Matrix3d& rotation);

/// The part of `rotation` about the unit vector `axis` (swing-twist decomposition), as an angle in (-pi, pi].
double twist_angle(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& axis);

/// The rotation of least angle that takes direction `from` to direction `to` (neither need be normalised; for opposite
/// directions the axis is the coordinate axis farthest from them, orthogonalised).
Eigen::Matrix3d minimal_rotation(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

/// Rotation vector (axis times angle, angle in [0, pi]) of a rotation, and back. Both keep full precision near zero.
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& rotation);
Eigen::Matrix3d rotation_of(const Eigen::Vector3d& rotation_vector);

}  // namespace ndg
