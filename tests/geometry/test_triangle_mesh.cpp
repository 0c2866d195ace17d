// SPDX-License-Identifier: Apache-2.0
#include "geometry/shapes.h"
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/geometry/triangle_mesh.h"

#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>

#include <array>
#include <cmath>
#include <initializer_list>
#include <set>
#include <utility>
#include <vector>

using namespace ndg;
using ndg::test::Surface;

namespace {

/// Irregular flat patch: a jittered grid of n x n vertices in the plane z = 0, normals +z.
Surface flat_patch(int n)
{
    Random random(21, "patch");
    Surface patch;
    patch.vertices.resize(n * n, 3);
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            patch.vertices.row(i * n + j) << i + random.uniform(-0.3, 0.3), j + random.uniform(-0.3, 0.3), 0.0;
        }
    }
    patch.triangles.resize(2 * (n - 1) * (n - 1), 3);
    int t = 0;
    for (int i = 0; i + 1 < n; ++i) {
        for (int j = 0; j + 1 < n; ++j) {
            const int v = i * n + j;
            patch.triangles.row(t++) << v, v + n, v + n + 1;
            patch.triangles.row(t++) << v, v + n + 1, v + 1;
        }
    }
    return patch;
}

Triangles rows(std::initializer_list<std::array<int, 3>> list)
{
    Triangles triangles(static_cast<Eigen::Index>(list.size()), 3);
    Eigen::Index t = 0;
    for (const auto& row : list) triangles.row(t++) << row[0], row[1], row[2];
    return triangles;
}

}  // namespace

TEST_CASE("triangle mesh: normals, areas and volume of the cube and the sphere")
{
    const Surface cube = test::cube();
    CHECK(enclosed_volume(cube.vertices, cube.triangles) == Approx(1.0).epsilon(1e-14));
    CHECK(triangle_areas(cube.vertices, cube.triangles).sum() == Approx(6.0).epsilon(1e-14));
    CHECK(vertex_areas(cube.vertices, cube.triangles).sum() == Approx(6.0).epsilon(1e-14));
    CHECK(triangle_normals(cube.vertices, cube.triangles).row(2) == Eigen::RowVector3d(0, 0, 1));
    // Far from the origin the volume keeps its digits.
    const Points far = cube.vertices.rowwise() + Eigen::RowVector3d(1e5, 1e5, 1e5);
    CHECK(enclosed_volume(far, cube.triangles) == Approx(1.0).epsilon(1e-9));

    const Surface sphere = test::icosphere(2.0, 4);
    CHECK(enclosed_volume(sphere.vertices, sphere.triangles) == Approx(4.0 / 3.0 * M_PI * 8.0).epsilon(5e-3));
    const Points normals = vertex_normals(sphere.vertices, sphere.triangles);
    CHECK((normals - sphere.vertices / 2.0).rowwise().norm().maxCoeff() < 2e-2);

    Points with_loose_vertex(9, 3);
    with_loose_vertex << cube.vertices, Eigen::RowVector3d(5, 5, 5);
    CHECK(vertex_normals(with_loose_vertex, cube.triangles).row(8).norm() == 0.0);
}

TEST_CASE("triangle mesh: edges of two triangles")
{
    const auto edges = mesh_edges(rows({{0, 1, 2}, {2, 1, 3}}), 4);
    REQUIRE(edges.size() == 5);
    int inner = 0;
    for (const auto& edge : edges) {
        if (edge.right_triangle < 0) {
            CHECK(edge.right_vertex == -1);
            continue;
        }
        ++inner;
        CHECK(edge.v0 == 1);
        CHECK(edge.v1 == 2);
        CHECK(edge.left_triangle == 0);
        CHECK(edge.left_vertex == 0);
        CHECK(edge.right_triangle == 1);
        CHECK(edge.right_vertex == 3);
    }
    CHECK(inner == 1);
    // A boundary edge keeps the direction of its triangle.
    const auto single = mesh_edges(rows({{2, 1, 0}}), 3);
    const std::set<std::pair<int, int>> directed{
        {single[0].v0, single[0].v1}, {single[1].v0, single[1].v1}, {single[2].v0, single[2].v1}};
    CHECK(directed == std::set<std::pair<int, int>>{{2, 1}, {1, 0}, {0, 2}});

    const Surface sphere = test::icosphere(1.0, 2);
    CHECK(mesh_edges(sphere.triangles, static_cast<int>(sphere.vertices.rows())).size() == 480);
    CHECK_THROWS_AS(mesh_edges(rows({{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}), 5), Error);
    CHECK_THROWS_AS(mesh_edges(rows({{0, 1, 2}, {0, 1, 3}}), 4), Error);
    CHECK_THROWS_AS(mesh_edges(rows({{0, 1, 4}}), 4), Error);
}

TEST_CASE("triangle mesh: boundary loops and neighbours")
{
    const auto loops = boundary_loops(rows({{0, 1, 2}, {2, 1, 3}}), 4);
    REQUIRE(loops.size() == 1);
    CHECK(loops[0] == std::vector<int>{0, 1, 3, 2});
    CHECK(boundary_loops(test::cube().triangles, 8).empty());

    // A cube without bottom and top has two loops.
    const Surface cube = test::cube();
    const Triangles tube = cube.triangles.bottomRows(8);
    CHECK(boundary_loops(tube, 8).size() == 2);
    // Two triangles that touch in a vertex.
    const auto touching = boundary_loops(rows({{0, 1, 2}, {2, 3, 4}}), 5);
    std::size_t length = 0;
    for (const auto& loop : touching) length += loop.size();
    CHECK(length == 6);

    const auto neighbours = vertex_neighbours(rows({{0, 1, 2}, {2, 1, 3}}), 5);
    CHECK(neighbours[1] == std::vector<int>{0, 2, 3});
    CHECK(neighbours[4].empty());
}

TEST_CASE("triangle mesh: cotangent Laplacian")
{
    const Surface sphere = test::icosphere(1.0, 1);
    const Eigen::MatrixXd laplacian = cotangent_laplacian(sphere.vertices, sphere.triangles);
    CHECK((laplacian - laplacian.transpose()).norm() < 1e-14);
    CHECK((laplacian * Eigen::VectorXd::Ones(laplacian.rows())).norm() < 1e-13);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(laplacian, Eigen::EigenvaluesOnly);
    CHECK(solver.eigenvalues()[0] > -1e-13);
    CHECK(solver.eigenvalues()[1] > 1e-3);

    // One right triangle by hand: cotangents 0 at the right angle and 1 at the other two.
    Points triangle(3, 3);
    triangle << 0, 0, 0, 1, 0, 0, 0, 1, 0;
    Eigen::Matrix3d expected;
    expected << 1, -0.5, -0.5, -0.5, 0.5, 0, -0.5, 0, 0.5;
    CHECK((Eigen::MatrixXd(cotangent_laplacian(triangle, rows({{0, 1, 2}}))) - expected).norm() < 1e-15);

    // Linear functions are harmonic inside a flat patch, and the Dirichlet energy of a linear function is exact.
    constexpr int n = 7;
    const Surface patch = flat_patch(n);
    const Eigen::SparseMatrix<double> flat = cotangent_laplacian(patch.vertices, patch.triangles);
    const Eigen::VectorXd linear = 2.0 * patch.vertices.col(0) - 3.0 * patch.vertices.col(1);
    const Eigen::VectorXd residual = flat * linear;
    for (int i = 1; i + 1 < n; ++i) {
        for (int j = 1; j + 1 < n; ++j) CHECK(std::abs(residual[i * n + j]) < 1e-12);
    }
    const double area = triangle_areas(patch.vertices, patch.triangles).sum();
    CHECK(linear.dot(residual) == Approx(13.0 * area).epsilon(1e-12));

    triangle.row(2) << 2, 0, 0;
    CHECK_THROWS_AS(cotangent_laplacian(triangle, rows({{0, 1, 2}})), Error);
}

TEST_CASE("triangle mesh: defects of a skin are named")
{
    const Surface cube = test::cube();
    CHECK(closed_surface_defect(cube.vertices, cube.triangles).empty());

    const Triangles open = cube.triangles.topRows(11);
    CHECK_THAT(closed_surface_defect(cube.vertices, open), Catch::StartsWith("open: edge"));
    Triangles inward = cube.triangles;
    inward.col(1).swap(inward.col(2));
    CHECK_THAT(closed_surface_defect(cube.vertices, inward), Catch::StartsWith("faces inwards"));
    Triangles one_flipped = cube.triangles;
    std::swap(one_flipped(3, 1), one_flipped(3, 2));
    CHECK_THAT(closed_surface_defect(cube.vertices, one_flipped), Catch::StartsWith("non-manifold: the two triangles"));
    Triangles wrong_index = cube.triangles;
    wrong_index(5, 0) = 8;
    CHECK_THAT(closed_surface_defect(cube.vertices, wrong_index), Catch::Contains("triangle 5 names vertex 8"));
    Triangles degenerate = cube.triangles;
    degenerate(5, 0) = degenerate(5, 1);
    CHECK_THAT(closed_surface_defect(cube.vertices, degenerate), Catch::StartsWith("degenerate: triangle 5"));
    Points not_finite = cube.vertices;
    not_finite(3, 1) = std::nan("");
    CHECK_THAT(closed_surface_defect(not_finite, cube.triangles), Catch::StartsWith("not finite"));
    CHECK_THAT(closed_surface_defect(cube.vertices, Triangles(0, 3)), Catch::StartsWith("empty"));
    Points loose(9, 3);
    loose << cube.vertices, Eigen::RowVector3d(5, 5, 5);
    CHECK_THAT(closed_surface_defect(loose, cube.triangles), Catch::StartsWith("unused: vertex 8"));

    // Two cubes that share one vertex, then an edge with a third triangle.
    Points two_vertices(15, 3);
    two_vertices << cube.vertices, cube.vertices.bottomRows(7).rowwise() + Eigen::RowVector3d(1, 1, 1);
    Triangles two(24, 3);
    two << cube.triangles, cube.triangles;
    for (Eigen::Index t = 12; t < 24; ++t) {
        for (int corner = 0; corner < 3; ++corner) two(t, corner) = two(t, corner) == 0 ? 7 : two(t, corner) + 7;
    }
    CHECK_THAT(closed_surface_defect(two_vertices, two), Catch::StartsWith("non-manifold: vertex 7"));
    Triangles fin(13, 3);
    fin << cube.triangles, Eigen::RowVector3i(0, 2, 7);
    CHECK_THAT(closed_surface_defect(cube.vertices, fin), Catch::StartsWith("non-manifold: edge 0-2 has 3 triangles"));

    // Two separate parts, one of which faces inwards, though the sum of the volumes is positive.
    Points parts(16, 3);
    parts << 3.0 * cube.vertices, cube.vertices.rowwise() + Eigen::RowVector3d(10, 0, 0);
    Triangles part_triangles(24, 3);
    part_triangles << cube.triangles, (inward.array() + 8).matrix();
    CHECK_THAT(closed_surface_defect(parts, part_triangles),
               Catch::StartsWith("faces inwards: the part with vertex 8"));
}

TEST_CASE("triangle mesh: dihedral angle")
{
    // All edges of the cube are convex right angles or flat diagonals.
    const Surface cube = test::cube();
    for (const auto& edge : mesh_edges(cube.triangles, 8)) {
        const double angle = dihedral_angle(cube.vertices.row(edge.v0), cube.vertices.row(edge.v1),
                                            cube.vertices.row(edge.left_vertex), cube.vertices.row(edge.right_vertex));
        const double length = (cube.vertices.row(edge.v0) - cube.vertices.row(edge.v1)).norm();
        CHECK(angle == Approx(length > 1.1 ? 0.0 : M_PI / 2).margin(1e-14));
    }
    const Eigen::Vector3d x0(0, 0, 0);
    const Eigen::Vector3d x1(0, 0, 2);
    for (const double bend : {-2.5, -0.4, 0.0, 1e-9, 0.7, 3.0}) {
        // Left vertex fixed at +x, right vertex turned about the edge.
        const Eigen::Vector3d left(1, 0, 0.5);
        const Eigen::Vector3d right(-std::cos(bend), -std::sin(bend), 0.3);
        CHECK(dihedral_angle(x0, x1, left, right) == Approx(bend).epsilon(1e-12).margin(1e-15));
        CHECK(dihedral_angle(x1, x0, right, left) == Approx(bend).epsilon(1e-12).margin(1e-15));
    }
    CHECK(std::abs(dihedral_angle(x0, x1, {1, 0, 0}, {1, 0, 0})) == Approx(M_PI));
}
