// SPDX-License-Identifier: Apache-2.0
#include "ndg/elastic/unposed_term.h"

#include <Eigen/LU>

#include <algorithm>

namespace ndg {

namespace {

constexpr double least_determinant = 1e-4;

}  // namespace

UnposedMaps::UnposedMaps(int num_vertices) : unposed_from_world_(num_vertices, AffineMap::Identity()) {}

void UnposedMaps::set_world_from_unposed(const std::vector<AffineMap>& world_from_unposed)
{
    require(world_from_unposed.size() == unposed_from_world_.size(), "{} maps from unposed space for {} vertices",
            world_from_unposed.size(), unposed_from_world_.size());
    const std::vector<AffineMap> inverse = invert_maps(world_from_unposed);
    std::copy(inverse.begin(), inverse.end(), unposed_from_world_.begin());
}

std::vector<AffineMap> invert_maps(const std::vector<AffineMap>& maps)
{
    std::vector<AffineMap> result(maps.size());
    for (std::size_t v = 0; v < maps.size(); ++v) {
        const Eigen::Matrix3d linear = maps[v].leftCols<3>();
        const double determinant = linear.determinant();
        require(maps[v].allFinite() && determinant >= least_determinant,
                "skinning squeezes space at vertex {} to {:.2e} of its volume, which cannot be undone", v, determinant);
        result[v].leftCols<3>() = linear.inverse();
        result[v].col(3) = -(result[v].leftCols<3>() * maps[v].col(3));
    }
    return result;
}

Points apply_maps(const std::vector<AffineMap>& maps, const Eigen::Ref<const Points>& points)
{
    require(static_cast<Eigen::Index>(maps.size()) == points.rows(), "{} maps for {} vertices", maps.size(),
            points.rows());
    Points moved(points.rows(), 3);
    for (Eigen::Index v = 0; v < points.rows(); ++v) {
        const AffineMap& map = maps[static_cast<std::size_t>(v)];
        moved.row(v) = (map.leftCols<3>() * points.row(v).transpose() + map.col(3)).transpose();
    }
    return moved;
}

}  // namespace ndg
