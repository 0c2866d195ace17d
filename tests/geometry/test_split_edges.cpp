// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/split_edges.h"
#include "ndg/geometry/triangle_mesh.h"

#include <catch2/catch.hpp>

using namespace ndg;

TEST_CASE("Splitting long edges keeps a surface closed, its area, its volume and what is linear on it")
{
    // A tetrahedron of edges from 1 to 1.41, with x + 2 y + 3 z as an attribute.
    RowMatrix attributes(4, 4);
    attributes << 0, 0, 0, 0, 1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3;
    Triangles triangles(4, 3);
    triangles << 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3;
    const RowMatrix before = attributes;
    const double area = triangle_areas(Points(attributes.leftCols(3)), triangles).sum();
    split_long_edges(attributes, triangles, 0.3);

    const Points points = attributes.leftCols(3);
    CHECK(attributes.topRows(4) == before);
    double longest = 0, volume = 0;
    for (const MeshEdge& edge : mesh_edges(triangles, static_cast<int>(points.rows()))) {
        CHECK(edge.right_triangle >= 0);
        longest = std::max(longest, (points.row(edge.v0) - points.row(edge.v1)).norm());
    }
    for (Eigen::Index t = 0; t < triangles.rows(); ++t)
        volume += points.row(triangles(t, 0)).dot(points.row(triangles(t, 1)).cross(points.row(triangles(t, 2)))) / 6;
    CHECK(longest <= 0.3);
    CHECK(longest > 0.15);
    CHECK(volume == Approx(1.0 / 6.0).epsilon(1e-12));
    CHECK(triangle_areas(points, triangles).sum() == Approx(area).epsilon(1e-12));
    CHECK((attributes.col(3) - points * Eigen::Vector3d(1, 2, 3)).cwiseAbs().maxCoeff() < 1e-12);
}

TEST_CASE("A rule of the place splits edges there and leaves others as they are")
{
    // A strip of squares of one metre along x, each of two triangles; edges beyond x = 5 must be shorter than 0.4.
    RowMatrix attributes(22, 3);
    Triangles triangles(20, 3);
    for (int i = 0; i <= 10; ++i) attributes.middleRows(2 * i, 2) << i, 0, 0, i, 1, 0;
    for (int i = 0; i < 10; ++i)
        triangles.middleRows(2 * i, 2) << 2 * i, 2 * i + 2, 2 * i + 1, 2 * i + 1, 2 * i + 2, 2 * i + 3;
    const double area = triangle_areas(Points(attributes), triangles).sum();
    split_edges(attributes, triangles, [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
        return (a - b).norm() > 0.4 && 0.5 * (a + b).x() > 5;
    });
    const Points points = attributes;
    CHECK(triangle_areas(points, triangles).sum() == Approx(area).epsilon(1e-12));
    int far = 0;
    for (const MeshEdge& edge : mesh_edges(triangles, static_cast<int>(points.rows()))) {
        const Eigen::RowVector3d middle = 0.5 * (points.row(edge.v0) + points.row(edge.v1));
        const double length = (points.row(edge.v0) - points.row(edge.v1)).norm();
        if (middle.x() > 5.1) CHECK(length <= 0.4);  // nearer to where the rule jumps twelve rounds are not enough
        if (middle.x() < 4) CHECK(length >= 1.0);
        far += middle.x() > 5;
    }
    CHECK(far > 100);
}
