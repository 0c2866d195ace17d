// SPDX-License-Identifier: Apache-2.0
#include "geometry/shapes.h"
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/geometry/tetrahedra.h"
#include "ndg/geometry/tetrahedralize.h"
#include "ndg/geometry/triangle_mesh.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;
using ndg::test::Surface;

TEST_CASE("tetrahedra: volume and barycentric coordinates")
{
    const Eigen::Vector3d a(0, 0, 0);
    const Eigen::Vector3d b(2, 0, 0);
    const Eigen::Vector3d c(0, 3, 0);
    const Eigen::Vector3d d(0, 0, 4);
    CHECK(tetrahedron_volume(a, b, c, d) == Approx(4.0));
    CHECK(tetrahedron_volume(a, c, b, d) == Approx(-4.0));
    Random random(41, "tet");
    for (int trial = 0; trial < 20; ++trial) {
        Eigen::Vector4d expected;
        for (int i = 0; i < 4; ++i) expected[i] = random.uniform(-1, 1);
        expected[3] = 1.0 - expected.head<3>().sum();
        const Eigen::Vector3d point = expected[0] * a + expected[1] * b + expected[2] * c + expected[3] * d;
        CHECK((tetrahedron_coordinates(a, b, c, d, point) - expected).norm() < 1e-13);
    }
}

TEST_CASE("tetrahedralize fills a cube and keeps its triangles")
{
    const Surface cube = test::cube();
    const TetrahedralMesh mesh = tetrahedralize(cube.vertices, cube.triangles);
    CHECK(mesh.vertices.topRows(8) == cube.vertices);
    const Eigen::VectorXd volumes = tetrahedron_volumes(mesh.vertices, mesh.tetrahedra);
    CHECK(volumes.minCoeff() > 0.0);
    CHECK(volumes.sum() == Approx(1.0).epsilon(1e-12));
}

TEST_CASE("tetrahedralize fills a sphere, finer when asked")
{
    const Surface sphere = test::icosphere(0.1, 2);
    const double volume = enclosed_volume(sphere.vertices, sphere.triangles);
    const TetrahedralMesh coarse = tetrahedralize(sphere.vertices, sphere.triangles);
    const double limit = volume / 1000.0;
    const TetrahedralMesh fine = tetrahedralize(sphere.vertices, sphere.triangles, limit);
    for (const TetrahedralMesh* mesh : {&coarse, &fine}) {
        CHECK(mesh->vertices.topRows(sphere.vertices.rows()) == sphere.vertices);
        const Eigen::VectorXd volumes = tetrahedron_volumes(mesh->vertices, mesh->tetrahedra);
        CHECK(volumes.minCoeff() > 0.0);
        CHECK(volumes.sum() == Approx(volume).epsilon(1e-10));
    }
    CHECK(fine.tetrahedra.rows() > 1000);
    // The bound holds inside; the kept triangles of the surface are too large for it to hold at them.
    const Eigen::VectorXd fine_volumes = tetrahedron_volumes(fine.vertices, fine.tetrahedra);
    int inside = 0;
    for (Eigen::Index t = 0; t < fine.tetrahedra.rows(); ++t) {
        if (fine.tetrahedra.row(t).minCoeff() < sphere.vertices.rows()) continue;
        ++inside;
        CHECK(fine_volumes[t] <= 1.01 * limit);
    }
    CHECK(inside > 100);
    const TetrahedralMesh again = tetrahedralize(sphere.vertices, sphere.triangles, limit);
    CHECK(again.vertices == fine.vertices);
    CHECK(again.tetrahedra == fine.tetrahedra);
}

TEST_CASE("tetrahedralize rejects surfaces that have no inside")
{
    const Surface cube = test::cube();
    const Triangles open = cube.triangles.topRows(11);
    CHECK_THROWS_AS(tetrahedralize(cube.vertices, open), InputError);
    Triangles inward = cube.triangles;
    inward.col(1).swap(inward.col(2));
    CHECK_THROWS_AS(tetrahedralize(cube.vertices, inward), InputError);

    // A vertex pulled through the opposite side of the sphere.
    Surface pierced = test::icosphere(0.1, 2);
    pierced.vertices.row(0) *= -1.3;
    CHECK_THROWS_WITH(tetrahedralize(pierced.vertices, pierced.triangles), Catch::Contains("intersects itself"));
    // Two cubes, one reaching into the other.
    Points vertices(16, 3);
    vertices << cube.vertices, cube.vertices.rowwise() + Eigen::RowVector3d(0.5, 0.3, 0.2);
    Triangles triangles(24, 3);
    triangles << cube.triangles, (cube.triangles.array() + 8).matrix();
    CHECK_THROWS_AS(tetrahedralize(vertices, triangles), InputError);
    // The same vertex twice: the cubes meet in one point without sharing the vertex.
    vertices.bottomRows(8) = cube.vertices.rowwise() + Eigen::RowVector3d(1, 1, 1);
    CHECK_THROWS_AS(tetrahedralize(vertices, triangles), Error);
    CHECK_THROWS_AS(tetrahedralize(cube.vertices, cube.triangles, std::nan("")), InputError);
}
