// SPDX-License-Identifier: Apache-2.0
#include "ndg/elastic/contact_barrier.h"

#include <Eigen/Geometry>

#include <cmath>
#include <limits>

namespace ndg {

ContactBarrier contact_barrier(double squared_distance, double squared_reach)
{
    ContactBarrier barrier;
    if (squared_distance >= squared_reach) return barrier;
    if (!(squared_distance > 0)) {
        barrier.energy = std::numeric_limits<double>::infinity();
        return barrier;
    }
    const double y = squared_distance / squared_reach, depth = 1 - y, log = std::log(y), ratio = depth / y;
    barrier.energy = -depth * depth * log;
    barrier.first = (2 * depth * log - depth * ratio) / squared_reach;
    barrier.second = (-2 * log + 4 * ratio + ratio * ratio) / (squared_reach * squared_reach);
    return barrier;
}

ParallelFade parallel_fade(const Eigen::Matrix<double, 4, 3>& corners, double limit)
{
    ParallelFade fade;
    const Eigen::Vector3d u = corners.row(1) - corners.row(0), v = corners.row(3) - corners.row(2);
    const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v);
    const double share = u.cross(v).squaredNorm() / limit;
    if (share >= 1) return fade;
    // Of c by u and v, then by the corners, of which u and v are differences.
    Eigen::Matrix<double, 6, 1> by_edges;
    by_edges << 2 * (vv * u - uv * v), 2 * (uu * v - uv * u);
    Eigen::Matrix<double, 6, 6> second;
    const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
    const Eigen::Matrix3d mixed = 4 * u * v.transpose() - 2 * v * u.transpose() - 2 * uv * identity;
    second << 2 * (vv * identity - v * v.transpose()), mixed, mixed.transpose(),
        2 * (uu * identity - u * u.transpose());
    Eigen::Matrix<double, 6, 12> edges = Eigen::Matrix<double, 6, 12>::Zero();
    edges.block<3, 3>(0, 0) = edges.block<3, 3>(3, 6) = -identity;
    edges.block<3, 3>(0, 3) = edges.block<3, 3>(3, 9) = identity;
    const Eigen::Matrix<double, 12, 1> gradient = edges.transpose() * by_edges;
    fade.value = (2 - share) * share;
    fade.gradient = 2 * (1 - share) / limit * gradient;
    fade.hessian = 2 * (1 - share) / limit * edges.transpose() * second * edges -
                   2 / (limit * limit) * gradient * gradient.transpose();
    return fade;
}

}  // namespace ndg
