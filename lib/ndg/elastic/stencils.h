// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

namespace ndg {

/// Which vertices every element of an energy term depends on: its corners, of the same number for all elements.
class Stencils {
public:
    /// `vertices`: those of the first element's corners, then of the second's. `apart`: pairs of corners, the smaller
    /// first, that have no cell of the mesh in common, as the two wing vertices of a hinge. Throws Error for a vertex
    /// out of range.
    Stencils(int num_corners, std::vector<int> vertices, int num_vertices, std::vector<std::pair<int, int>> apart = {});

    int num_corners() const { return num_corners_; }
    int num_vertices() const { return static_cast<int>(around_begin_.size()) - 1; }
    int size() const { return static_cast<int>(vertices_.size()) / num_corners_; }
    const int* corners(int element) const { return &vertices_[num_corners_ * element]; }

    /// Elements with at least one of the vertices, ascending.
    std::vector<int> elements_at(const std::vector<int>& vertices) const;
    /// Whether two different corners have a cell in common.
    bool adjacent(int a, int b) const
    {
        return std::find(adjacent_.begin(), adjacent_.end(), std::pair<int, int>(a, b)) != adjacent_.end();
    }
    /// visit(a, b) for every ordered pair of different corners of a cell.
    template <class Visit>
    void for_adjacent(const Visit& visit) const
    {
        for (const auto& [a, b] : adjacent_) {
            for (int e = 0; e < size(); ++e) visit(corners(e)[a], corners(e)[b]);
        }
    }

private:
    int num_corners_;
    std::vector<int> vertices_;
    std::vector<std::pair<int, int>> adjacent_;
    std::vector<int> around_begin_,
        around_;  ///< of vertex v: around_[around_begin_[v]] to around_[around_begin_[v + 1]]
};

}  // namespace ndg
