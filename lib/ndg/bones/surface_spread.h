// SPDX-License-Identifier: Apache-2.0
// Pushes at single vertices of a surface made smooth bumps of it.
#pragma once

#include "ndg/core/types.h"

#include <vector>

namespace ndg {

/// Of a surface at rest: nodes on it at least `spacing` (m) apart, and which lie how near to which along its edges.
/// What is spread goes by way of the nodes, so that it costs the same however fine the surface is.
class SurfaceSpread {
public:
    /// `vertices` N x 3. `reach`: the largest width that is asked for, m.
    SurfaceSpread(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles, double reach,
                  double spacing = 0.012);

    /// `vectors` N x 3, zero but at `sources`. Each node takes the longest vector of the vertices that are nearest to
    /// it, then the mean of those within `width`, the nearer ones counting more; the vertices between blend the nodes
    /// about them. Returns the vertices whose vectors are no longer zero. The same for any number of threads.
    std::vector<int> spread(const std::vector<int>& sources, double width, Points& vectors) const;

private:
    struct Near {
        int index;
        float value;  ///< distance (m) or weight
    };
    struct Lists {
        std::vector<int> begins = {0};
        std::vector<Near> entries;
    };
    std::vector<int> node_of_;  ///< of each vertex, the nearest
    Lists nodes_;               ///< of each node the nodes within reach with their distances, the nearest first
    Lists vertices_;            ///< of each node the vertices that it has a part in with its weight there
};

}  // namespace ndg
