// SPDX-License-Identifier: Apache-2.0
#include "ndg/scan/retriangulate.h"

#include "ndg/geometry/split_edges.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace ndg {
namespace {

/// Farthest that a vertex moves towards a point of one of its triangles (share): neighbours do not meet.
constexpr double max_move = 0.4;
/// Least cosine between the normals of two triangles whose common edge may be flipped.
constexpr double coplanar = 0.995;
/// Share of the flippable edges that are flipped.
constexpr double flip_share = 0.5;

double squared_edge(const RowMatrix& attributes, int a, int b)
{
    return (attributes.row(a).head<3>() - attributes.row(b).head<3>()).squaredNorm();
}

void jitter(RowMatrix& attributes, const Triangles& triangles, Random& random)
{
    std::vector<std::vector<int>> vertex_triangles(attributes.rows());
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        for (int k = 0; k < 3; ++k) {
            vertex_triangles[triangles(t, k)].push_back(static_cast<int>(t));
        }
    }
    const RowMatrix old = attributes;
    for (Eigen::Index v = 0; v < attributes.rows(); ++v) {
        const auto& around = vertex_triangles[v];
        if (around.empty()) continue;
        const int t = around[random.below(around.size())];
        double u = random.uniform(), w = random.uniform();
        if (u + w > 1.0) {
            u = 1.0 - u;
            w = 1.0 - w;
        }
        const Eigen::RowVectorXd place =
            (1.0 - u - w) * old.row(triangles(t, 0)) + u * old.row(triangles(t, 1)) + w * old.row(triangles(t, 2));
        attributes.row(v) += max_move * (place - old.row(v));
    }
}

void flip_edges(const RowMatrix& attributes, Triangles& triangles, Random& random)
{
    const Points positions = attributes.leftCols(3);
    const Points normals = triangle_normals(positions, triangles);
    std::vector<char> used(triangles.rows(), 0);
    const auto normal = [&](int a, int b, int c) -> Eigen::RowVector3d {
        return (positions.row(b) - positions.row(a)).cross(positions.row(c) - positions.row(a));
    };
    const auto edges = mesh_edges(triangles, static_cast<int>(attributes.rows()));
    std::vector<std::vector<int>> neighbours = vertex_neighbours(triangles, static_cast<int>(attributes.rows()));
    for (const MeshEdge& e : edges) {
        if (e.right_triangle < 0 || random.uniform() > flip_share) continue;
        char& left_used = used[e.left_triangle];
        char& right_used = used[e.right_triangle];
        if (left_used || right_used || normals.row(e.left_triangle).dot(normals.row(e.right_triangle)) < coplanar) {
            continue;
        }
        auto& known = neighbours[e.left_vertex];
        if (std::find(known.begin(), known.end(), e.right_vertex) != known.end()) continue;
        // (v0, v1, left), (v1, v0, right) become (left, v0, right), (right, v1, left).
        const Eigen::RowVector3d first = normal(e.left_vertex, e.v0, e.right_vertex);
        const Eigen::RowVector3d second = normal(e.right_vertex, e.v1, e.left_vertex);
        const Eigen::RowVector3d up = normals.row(e.left_triangle);
        const double diagonal = squared_edge(attributes, e.left_vertex, e.right_vertex);
        // No needles: both new triangles keep a fifth of the square over the new edge.
        if (first.dot(up) < 0.2 * diagonal || second.dot(up) < 0.2 * diagonal) continue;
        triangles.row(e.left_triangle) << e.left_vertex, e.v0, e.right_vertex;
        triangles.row(e.right_triangle) << e.right_vertex, e.v1, e.left_vertex;
        known.push_back(e.right_vertex);
        neighbours[e.right_vertex].push_back(e.left_vertex);
        left_used = right_used = 1;
    }
}

}  // namespace

void retriangulate(RowMatrix& attributes, Triangles& triangles, int num_vertices, Random& random)
{
    // An equilateral triangulation has one vertex per sqrt(3)/2 of the squared edge; splitting at a limit leaves edges
    // of between half of it and all of it, about 0.72 of it in the mean.
    const double area = triangle_areas(Points(attributes.leftCols(3)), triangles).sum();
    const double limit = std::sqrt(area / num_vertices / (0.5 * std::sqrt(3.0))) / 0.72;
    split_long_edges(attributes, triangles, limit);
    jitter(attributes, triangles, random);
    flip_edges(attributes, triangles, random);
}

}  // namespace ndg
