// SPDX-License-Identifier: Apache-2.0
#include "geometry/shapes.h"
#include "ndg/geometry/intersections.h"
#include "ndg/geometry/triangle_mesh.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <utility>
#include <vector>

using namespace ndg;

namespace {

TriangleMesh sphere_mesh(double radius, int levels)
{
    const test::Surface sphere = test::icosphere(radius, levels);
    return {sphere.vertices, sphere.triangles};
}

}  // namespace

TEST_CASE("self-intersections are found and neighbours are none")
{
    const TriangleMesh sphere = sphere_mesh(1.0, 2);
    CHECK(self_intersections(sphere.vertices, sphere.triangles).empty());
    Points vertices(9, 3);
    vertices << 0, 0, 0, 2, 0, 0, 0, 2, 0,   // in the plane z = 0
        0.5, 0.5, -1, 0.5, 0.5, 1, 3, 3, 0,  // pierces it
        0.5, 0.5, 5, 0.5, 1.5, 5, 3, 3, 5;   // far above
    Triangles triangles(3, 3);
    triangles << 0, 1, 2, 3, 4, 5, 6, 7, 8;
    CHECK(self_intersections(vertices, triangles) == std::vector<std::pair<int, int>>{{0, 1}});
    // Triangles shrunk to segments: one pierces the first triangle, one misses it.
    vertices.row(5) << 0.5, 0.5, 0.0;
    CHECK(self_intersections(vertices, triangles) == std::vector<std::pair<int, int>>{{0, 1}});
    vertices.row(3) << 5, 5, -1;
    vertices.row(4) << 5, 5, 1;
    vertices.row(5) << 5, 5, 0;
    CHECK(self_intersections(vertices, triangles).empty());
    // Touching counts, sharing a vertex does not.
    vertices.row(3) << 1, 0, 0;
    vertices.row(4) << 1, -1, 1;
    vertices.row(5) << 1, -1, -1;
    CHECK(self_intersections(vertices, triangles).size() == 1);
    triangles.row(1) << 0, 4, 5;
    CHECK(self_intersections(vertices, triangles).empty());
}

TEST_CASE("self-intersections of neighbours, and of two surfaces")
{
    using Pairs = std::vector<std::pair<int, int>>;
    Points vertices(5, 3);
    vertices << 0, 0, 0, 2, 0, 0, 0, 2, 0, 1, 1, 1, 0.5, 0.5, -1;
    Triangles triangles(2, 3);
    triangles << 0, 1, 2, 0, 3, 4;  // share vertex 0; the second pierces the first
    CHECK(self_intersections(vertices, triangles).empty());
    CHECK(self_intersections(vertices, triangles, true) == Pairs{{0, 1}});
    vertices.row(4) << 0.5, 0.5, 2;  // now above it
    CHECK(self_intersections(vertices, triangles, true).empty());
    triangles << 0, 1, 2, 1, 0, 3;  // share an edge, at an angle
    CHECK(self_intersections(vertices, triangles, true).empty());
    vertices.row(3) << 0.5, 0.5, 0;  // folded flat onto it
    CHECK(self_intersections(vertices, triangles, true) == Pairs{{0, 1}});
    vertices.row(3) << 0.5, -0.5, 0;  // unfolded
    CHECK(self_intersections(vertices, triangles, true).empty());

    const TriangleMesh outer = sphere_mesh(1.0, 2), inner = sphere_mesh(0.8, 2);
    CHECK(surface_intersections(outer.vertices, outer.triangles, inner.vertices, inner.triangles).empty());
    const Points shifted = inner.vertices.rowwise() + Eigen::RowVector3d(0.5, 0, 0);
    const auto pairs = surface_intersections(outer.vertices, outer.triangles, shifted, inner.triangles);
    CHECK(pairs.size() > 20);
    const auto swapped = surface_intersections(shifted, inner.triangles, outer.vertices, outer.triangles);
    CHECK(swapped.size() == pairs.size());
    for (const auto& [s, t] : pairs) CHECK(std::find(swapped.begin(), swapped.end(), std::pair{t, s}) != swapped.end());
}
