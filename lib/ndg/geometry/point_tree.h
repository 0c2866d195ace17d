// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"

#include <utility>
#include <vector>

namespace ndg {

/// k-d tree over points for nearest-neighbour queries. Queries may run in several threads at once. Ties go to the
/// lower index, so that results do not depend on the shape of the tree.
class PointTree {
public:
    /// At least one point (Error otherwise). Keeps a copy.
    explicit PointTree(const Eigen::Ref<const Points>& points);

    struct Neighbour {
        int idx = -1;
        double squared_distance = 0.0;  ///< m^2
        bool operator<(const Neighbour& other) const
        {
            return squared_distance != other.squared_distance ? squared_distance < other.squared_distance
                                                              : idx < other.idx;
        }
    };
    Neighbour nearest(const Eigen::Vector3d& query) const;
    /// The `count` nearest points, or all if there are fewer, nearest first.
    std::vector<Neighbour> nearest(const Eigen::Vector3d& query, int count) const;

private:
    struct Node {
        Eigen::Vector3d low, high;
        int right = -1;          ///< second child of an inner node; the first one is the next node
        int begin = 0, end = 0;  ///< points of a leaf, in order_
    };
    int build(int begin, int end);
    void search(const Eigen::Vector3d& query, std::vector<Neighbour>& heap, std::size_t count) const;

    Points points_;           ///< in tree order
    std::vector<int> order_;  ///< index of each of them as given
    std::vector<Node> nodes_;
};

}  // namespace ndg
