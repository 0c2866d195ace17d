// SPDX-License-Identifier: Apache-2.0
#include "ndg/export/rigid_motions.h"

#include <Eigen/Geometry>

namespace ndg {

std::optional<std::vector<Eigen::Isometry3d>> rigid_motions(const std::vector<Points>& vertices)
{
    constexpr double tolerance = 2e-5;  // m
    const Eigen::Matrix3Xd first = vertices[0].transpose();
    if (first.cols() < 3) return {};
    std::vector<Eigen::Isometry3d> motions;
    for (const Points& frame : vertices) {
        // By least squares (Umeyama 1991, without scale).
        const Eigen::Matrix3Xd moved = frame.transpose();
        Eigen::Isometry3d& motion = motions.emplace_back(Eigen::Isometry3d::Identity());
        motion.matrix() = Eigen::umeyama(first, moved, false);
        if ((motion * first - moved).colwise().norm().maxCoeff() > tolerance) return {};
    }
    return motions;
}

}  // namespace ndg
