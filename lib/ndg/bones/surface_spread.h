// SPDX-License-Identifier: Apache-2.0
// Pushes at places of a surface made smooth bumps of it.
#pragma once

#include "ndg/core/types.h"

#include <vector>

namespace ndg {

/// Points in single precision, one a column, aligned for vector instructions (the fourth row is not used).
using PointColumnsF = Eigen::Matrix<float, 4, Eigen::Dynamic>;

/// Of a surface at rest: nodes on it at least a spacing apart, and which lie how near to which along its edges. What is
/// spread goes by way of the nodes, so that it costs the same however fine the surface is.
class SurfaceSpread {
public:
    /// `vertices` N x 3, `widths` (m) over which pushes will be spread.
    SurfaceSpread(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                  const std::vector<double>& widths, double spacing = 0.012);

    int num_widths() const { return int(widths_.size()); }

    /// Pushes that are collected and spread, and what is kept between calls so that none of them allocates. One thread
    /// at a time.
    class Pushes {
    public:
        explicit Pushes(const SurfaceSpread& spread) { reset(spread); }
        /// Forgets all pushes, for use with a surface.
        void reset(const SurfaceSpread& spread);
        /// Of the pushes at vertices of which a node is the nearest the longest counts; of equally long ones the first.
        void add(int vertex, const Eigen::Vector3f& push);
        bool empty() const { return pushed_.empty(); }

    private:
        friend class SurfaceSpread;
        const SurfaceSpread* spread_ = nullptr;
        std::vector<int> pushed_, near_, touched_;  ///< nodes, nodes, nodes of cells
        std::vector<int> moved_;                    ///< vertices
        std::vector<float> bells_;                  ///< of the nodes about one
        std::vector<float> lengths_;                ///< of each node, squared
        PointColumnsF longest_, means_;             ///< of each node; zero between calls
        std::vector<char> is_near_, is_touched_;    ///< of nodes; 0 between calls
    };

    /// Moves `surface` (4 x N): each node takes the mean of the pushes of the nodes within a width, the nearer ones
    /// counting more, and the vertices blend the nodes about them. Returns the vertices that moved, until the next
    /// call; `pushes` is empty after it. The same for any number of threads.
    const std::vector<int>& spread(Pushes& pushes, int width_idx, PointColumnsF& surface) const;

private:
    std::vector<float> widths_;
    std::vector<int> node_of_;  ///< of each vertex, the nearest
    // Of each node the nodes within reach, the nearest first.
    std::vector<int> reached_begins_ = {0}, reached_;
    std::vector<float> distances_;
    Eigen::MatrixXf node_weights_;  ///< of each width (column) and node: the sum of the weights of all nodes about it
    std::vector<int> cell_begins_ = {0};  ///< of each node: the vertices that it is the nearest of
    std::vector<int> cells_;
    // Of each of those the nodes about it with their weights, filled up by weights of zero.
    struct Part {
        int node;
        float weight;
    };
    std::vector<int> part_begins_ = {0};
    std::vector<Part> parts_;
    std::vector<int> touched_begins_ = {0};  ///< of each node: the nodes in whose cells it has a part
    std::vector<int> touched_;
};

}  // namespace ndg
