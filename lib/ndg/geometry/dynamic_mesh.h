// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"

#include <array>
#include <vector>

namespace ndg {

/// A labelled manifold triangle mesh, open or closed, under local changes: edges are split, flipped and collapsed.
/// Feature edges are those of the boundary and those between two labels. Removed vertices have no triangles, removed
/// triangles hold -1; numbers of the others do not change.
class DynamicMesh {
public:
    DynamicMesh(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                const std::vector<int>& labels);

    int num_vertices() const { return static_cast<int>(positions.size()); }
    int num_triangles() const { return static_cast<int>(triangles.size()); }
    bool removed(int triangle) const { return triangles[triangle][0] < 0; }
    const std::array<int, 3>& triangle(int t) const { return triangles[t]; }
    const Eigen::Vector3d& position(int v) const { return positions[v]; }
    const std::vector<int>& triangles_of(int v) const { return vertex_triangles[v]; }
    int label(int t) const { return labels[t]; }

    /// Every edge once, as (a, b) with a < b, in a fixed order.
    std::vector<std::array<int, 2>> edges() const;
    /// The triangle with the directed edge a -> b and the one with b -> a; -1 for none.
    std::array<int, 2> edge_triangles(int a, int b) const;
    /// The corner of a triangle that is neither a nor b.
    int opposite(int t, int a, int b) const;
    bool is_feature(int a, int b) const;
    bool is_boundary(int a, int b) const;
    bool on_boundary(int v) const;
    /// Sorted.
    std::vector<int> neighbours(int v) const;
    /// Other ends of the feature edges of a vertex, sorted.
    std::vector<int> feature_neighbours(int v) const;

    /// New vertex in the middle of an edge, at `position`. Returns it.
    int split(int a, int b, const Eigen::Vector3d& position);
    /// Whether the edge can be replaced by the other diagonal: no feature edge, no such edge yet, and none
    /// that would cross the surface between two boundary vertices (two mirrored halves would share it).
    bool can_flip(int a, int b) const;
    void flip(int a, int b);
    /// Whether `removed` can be merged into its neighbour `kept` with surface, labels and features staying manifold
    /// chains: a vertex on a feature moves along it, one where features meet not at all. No edge across between two
    /// boundary vertices may arise.
    bool can_collapse(int removed, int kept) const;
    void collapse(int removed, int kept);

    /// Unit normal; zero for a flat triangle.
    Eigen::Vector3d normal(int t) const;
    /// Smallest angle of a triangle, radians; 0 for a flat one.
    static double min_angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

    /// What is left, renumbered in order; `old_of_new` receives the number each vertex had.
    void compact(Points& vertices, Triangles& remaining, std::vector<int>& remaining_labels,
                 std::vector<int>* old_of_new = nullptr) const;

    std::vector<Eigen::Vector3d> positions;
    std::vector<std::array<int, 3>> triangles;
    std::vector<int> labels;
    std::vector<std::vector<int>> vertex_triangles;

private:
    void detach(int v, int t);
};

}  // namespace ndg
