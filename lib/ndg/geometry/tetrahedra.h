// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"

namespace ndg {

/// Signed volume of one tetrahedron given its four vertices.
double tetrahedron_volume(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                          const Eigen::Vector3d& d);
/// Signed volumes, T.
Eigen::VectorXd tetrahedron_volumes(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Tetrahedra>& tets);
/// Barycentric coordinates of a point (they sum to one; all in [0, 1] inside).
Eigen::Vector4d tetrahedron_coordinates(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                                        const Eigen::Vector3d& d, const Eigen::Vector3d& point);

}  // namespace ndg
