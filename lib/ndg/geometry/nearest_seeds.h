// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/geometry/distance_grid.h"

#include <vector>

namespace ndg {

/// Points in units of the grid, at most one in the cube around each node.
struct SeedGrid {
    std::vector<int> seed_of_node;        ///< -1 for none
    std::vector<Eigen::Vector3f> points;  ///< relative to the grid's origin, in spacings
    std::vector<Eigen::Vector3f> normals;
};

/// Calls visit(i, j, k, index) for every node, in parallel.
template <typename Visit>
void for_each_node(const GridBox& box, const Visit& visit)
{
#pragma omp parallel for schedule(static)
    for (int k = 0; k < box.size[2]; ++k)
        for (int j = 0; j < box.size[1]; ++j)
            for (int i = 0; i < box.size[0]; ++i) visit(i, j, k, static_cast<std::size_t>(box.index(i, j, k)));
}

/// Replaces the seed of every node by the nearest one of the whole grid. One axis after the other is exact for
/// seeds on the nodes; ours lie beside them, so that a line may have been given the wrong one of two neighbours.
void find_nearest_seeds(const GridBox& box, SeedGrid& seeds);

}  // namespace ndg
