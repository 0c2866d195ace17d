// SPDX-License-Identifier: Apache-2.0
// Generalised winding numbers of many points (winding_numbers of closest_point.h gives them one by one, exactly).
#pragma once

#include "ndg/core/types.h"

#include <vector>

namespace ndg {

/// Half the solid angle, with the sign of its orientation, of a triangle with corners a, b, c seen from the origin,
/// given their lengths (Van Oosterom and Strackee 1983).
double half_solid_angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, double length_a,
                        double length_b, double length_c);

/// Winding numbers through a hierarchy of triangles (Barill et al. 2018): clusters that lie further away than two and a
/// half times their radius count as their dipole and its first derivative, others by their triangles. Within 0.02 of
/// the direct sum.
class WindingTree {
public:
    /// Throws Error for a mesh without triangles.
    WindingTree(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles);

    double winding_number(const Eigen::Vector3d& point) const;

private:
    struct Node {
        Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< of area
        double radius = 0.0;                               ///< about it, of all corners
        Eigen::Vector3d dipole = Eigen::Vector3d::Zero();  ///< sum of area times normal
        Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();  ///< sum of (centroid - centre) (area normal)^T
        int begin = 0, end = 0;                            ///< of the triangles below, in corners_
        int right = -1;                                    ///< second child, the first follows its parent; -1: a leaf
    };
    int build(std::vector<int>& order, int begin, int end);

    std::vector<Eigen::Matrix3d> corners_;  ///< of each triangle, one a column
    std::vector<Node> nodes_;
};

}  // namespace ndg
