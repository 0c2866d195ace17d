// SPDX-License-Identifier: Apache-2.0
#include "ndg/anatomical/fit.h"

#include "ndg/core/error.h"
#include "ndg/geometry/rotation.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>

namespace ndg {

Eigen::Affine3d fit_similarity(const Eigen::Ref<const Points>& from, const Eigen::Ref<const Points>& to)
{
    require(from.rows() >= 3 && from.rows() == to.rows(), "a similarity needs 3 pairs of points, not {} and {}",
            from.rows(), to.rows());
    return Eigen::Affine3d(Eigen::umeyama(from.transpose().eval(), to.transpose().eval(), true));
}

Eigen::Matrix3d frame_along(const Eigen::Vector3d& axis, const Eigen::Vector3d& reference)
{
    const Eigen::Vector3d first = axis.normalized();
    const Eigen::Vector3d across = reference - first * first.dot(reference);
    require(axis.norm() > 0.0 && across.norm() > 1e-9 * reference.norm() && reference.norm() > 0.0,
            "a frame's axis and reference are parallel");
    Eigen::Matrix3d frame;
    frame.col(0) = first;
    frame.col(1) = across.normalized();
    frame.col(2) = first.cross(frame.col(1));
    return frame;
}

Eigen::Affine3d bone_transform(const Eigen::Vector3d& source_start, const Eigen::Vector3d& source_end,
                               const Eigen::Vector3d& target_start, const Eigen::Vector3d& target_end,
                               const Eigen::Matrix3d& rotation, double transverse_scale)
{
    const Eigen::Vector3d source_axis = source_end - source_start, target_axis = target_end - target_start;
    require(source_axis.norm() > 0.0 && target_axis.norm() > 0.0, "a bone's two joint centres are the same");
    const Eigen::Vector3d unit = source_axis.normalized();
    const double axial_scale = target_axis.norm() / source_axis.norm();
    const Eigen::Matrix3d along = unit * unit.transpose();
    const Eigen::Matrix3d stretch = axial_scale * along + transverse_scale * (Eigen::Matrix3d::Identity() - along);
    Eigen::Affine3d transform;
    transform.linear() = minimal_rotation(rotation * unit, target_axis) * rotation * stretch;
    transform.translation() = target_start - transform.linear() * source_start;
    return transform;
}

}  // namespace ndg
