// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/tetrahedra.h"

namespace ndg {

double tetrahedron_volume(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                          const Eigen::Vector3d& d)
{
    return (b - a).cross(c - a).dot(d - a) / 6.0;
}

Eigen::VectorXd tetrahedron_volumes(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Tetrahedra>& tets)
{
    Eigen::VectorXd volumes(tets.rows());
    for (Eigen::Index t = 0; t < tets.rows(); ++t) {
        volumes[t] = tetrahedron_volume(vertices.row(tets(t, 0)), vertices.row(tets(t, 1)), vertices.row(tets(t, 2)),
                                        vertices.row(tets(t, 3)));
    }
    return volumes;
}

Eigen::Vector4d tetrahedron_coordinates(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                                        const Eigen::Vector3d& d, const Eigen::Vector3d& point)
{
    // Cramer's rule with the edges at `a`; the first coordinate completes the sum to one.
    const Eigen::Vector3d ab = b - a;
    const Eigen::Vector3d ac = c - a;
    const Eigen::Vector3d ad = d - a;
    const Eigen::Vector3d ap = point - a;
    const double six_volume = ab.cross(ac).dot(ad);
    Eigen::Vector4d coordinates;
    coordinates[1] = ap.cross(ac).dot(ad) / six_volume;
    coordinates[2] = ab.cross(ap).dot(ad) / six_volume;
    coordinates[3] = ab.cross(ac).dot(ap) / six_volume;
    coordinates[0] = 1.0 - coordinates[1] - coordinates[2] - coordinates[3];
    return coordinates;
}

}  // namespace ndg
