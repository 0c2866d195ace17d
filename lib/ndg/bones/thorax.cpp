// SPDX-License-Identifier: Apache-2.0
#include "ndg/bones/thorax.h"

#include "ndg/geometry/rotation.h"

#include <algorithm>

namespace ndg {

Eigen::Isometry3d sternum_motion(const std::array<Eigen::Isometry3d, num_vertebrae>& vertebrae,
                                 const Eigen::Vector3d& sternum_centre)
{
    constexpr int true_ribs = 7;
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    const Eigen::Vector4d reference = to_quaternion(vertebrae[std::size_t(thoracic_vertebra(1))].linear()).coeffs();
    double total = 0.0;
    for (int rib = 1; rib <= true_ribs; ++rib) {
        const Eigen::Isometry3d& motion = vertebrae[std::size_t(thoracic_vertebra(rib))];
        // The upper ribs are the shorter and stiffer ones.
        const double weight = true_ribs + 1 - rib;
        const Eigen::Vector4d quaternion = to_quaternion(motion.linear()).coeffs();
        sum += (quaternion.dot(reference) < 0.0 ? -weight : weight) * quaternion;
        centre += weight * (motion * sternum_centre);
        total += weight;
    }
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    motion.linear() = Eigen::Quaterniond(Eigen::Vector4d(sum.normalized())).toRotationMatrix();
    motion.translation() = centre / total - motion.linear() * sternum_centre;
    return motion;
}

Eigen::Isometry3d strut_motion(const Strut& strut, const Eigen::Isometry3d& first_bone,
                               const Eigen::Isometry3d& second_bone)
{
    const Eigen::Vector3d first = first_bone * strut.first, second = first_bone * strut.second;
    const Eigen::Vector3d wanted = second + strut.second_share * (second_bone * strut.second - second);
    Eigen::Isometry3d motion = first_bone;
    motion.linear() = minimal_rotation(second - first, wanted - first) * first_bone.linear();
    motion.translation() = first - motion.linear() * strut.first;
    return motion;
}

double sternum_share(int rib)
{
    return std::clamp((11.0 - rib) / 4.0, 0.0, 1.0);
}

}  // namespace ndg
