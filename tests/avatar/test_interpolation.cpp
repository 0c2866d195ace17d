// SPDX-License-Identifier: Apache-2.0
#include "ndg/avatar/control_points.h"
#include "ndg/avatar/volume_interpolation.h"
#include "ndg/core/error.h"
#include "ndg/geometry/tetrahedra.h"
#include "tube_body.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;

namespace {

/// The tube's bone wrap and axis.
struct Core {
    Points vertices;
    Tetrahedra tetrahedra;
    std::vector<bool> on_boundary;
};

Core tube_core()
{
    const Template tube = test::tube_template(9, 8);
    const int num_wrap = tube.num_wrap_vertices();
    Core core;
    core.vertices.resize(num_wrap + tube.rest.interior_vertices.rows(), 3);
    core.vertices << tube.rest.volume_vertices.topRows(num_wrap), tube.rest.interior_vertices;
    core.tetrahedra = tube.tetrahedra;
    core.on_boundary.assign(core.vertices.rows(), false);
    for (int v = 0; v < num_wrap; ++v) core.on_boundary[v] = true;
    // The ends of the axis lie in the open ends.
    core.on_boundary[num_wrap] = core.on_boundary.back() = true;
    return core;
}

}  // namespace

TEST_CASE("The Laplacian of tetrahedra is the energy of linear functions, by cotangents")
{
    const Core core = tube_core();
    const Eigen::SparseMatrix<double> laplacian = tetrahedral_laplacian(core.vertices, core.tetrahedra);
    const Eigen::Vector3d slope(0.3, -2.0, 1.1);
    const Eigen::VectorXd values = core.vertices * slope;
    const double volume = tetrahedron_volumes(core.vertices, core.tetrahedra).sum();
    CHECK(values.dot(laplacian * values) == Approx(slope.squaredNorm() * volume));
    CHECK((laplacian * Eigen::VectorXd::Ones(values.size())).norm() < 1e-12);
    CHECK((laplacian - Eigen::SparseMatrix<double>(laplacian.transpose())).norm() < 1e-14);

    // One tetrahedron: -1/6 of length times cotangent of the dihedral angle at the opposite edge.
    Points corners(4, 3);
    corners << 0, 0, 0, 1.2, 0.1, 0, 0.2, 0.9, 0.1, 0.3, 0.2, 1.1;
    Tetrahedra one(1, 4);
    one << 0, 1, 2, 3;
    const Eigen::SparseMatrix<double> single = tetrahedral_laplacian(corners, one);
    const Eigen::Vector3d edge = corners.row(3) - corners.row(2), axis = edge.normalized();
    const auto across = [&](int v) {
        const Eigen::Vector3d d = corners.row(v) - corners.row(2);
        return Eigen::Vector3d(d - axis * axis.dot(d));
    };
    const double cotangent = across(0).dot(across(1)) / across(0).cross(across(1)).norm();
    CHECK(single.coeff(0, 1) == Approx(-edge.norm() * cotangent / 6));
    one << 0, 2, 1, 3;
    CHECK_THROWS_WITH(tetrahedral_laplacian(corners, one), Catch::Contains("tetrahedron 0"));
}

TEST_CASE("Interpolation reproduces linear functions from the boundary and constants from anywhere")
{
    const Core core = tube_core();
    RowMatrix values(core.vertices.rows(), 2);
    values.col(0) = core.vertices * Eigen::Vector3d(0.3, -2.0, 1.1);
    values.col(1).setConstant(0.7);
    RowMatrix given = values;
    for (std::size_t v = 0; v < core.on_boundary.size(); ++v)
        if (!core.on_boundary[v]) given.row(Eigen::Index(v)).setConstant(99);
    const VolumeInterpolation interpolation(core.vertices, core.tetrahedra, core.on_boundary);
    CHECK((interpolation.interpolate(given) - values).cwiseAbs().maxCoeff() < 1e-12);

    std::vector<bool> one_ring(core.on_boundary.size(), false);
    for (int v = 0; v < 8; ++v) one_ring[v] = true;
    const RowMatrix carried =
        VolumeInterpolation(core.vertices, core.tetrahedra, one_ring).interpolate(values.rightCols(1));
    CHECK((carried.array() - 0.7).abs().maxCoeff() < 1e-10);
    CHECK_THROWS_AS(
        VolumeInterpolation(core.vertices, core.tetrahedra, std::vector<bool>(core.on_boundary.size(), false)), Error);
    Points with_loose(core.vertices.rows() + 1, 3);
    with_loose << core.vertices, Eigen::RowVector3d(1, 1, 1);
    one_ring.push_back(false);
    CHECK_THROWS_AS(VolumeInterpolation(with_loose, core.tetrahedra, one_ring), SolverError);
    CHECK_THROWS_AS(interpolation.interpolate(values.topRows(3)), Error);
}

TEST_CASE("Fields of control points are symmetric, smooth, and stay between their values")
{
    // Four squares a segment, so that the tessellation is its own mirror image.
    const Template tube = test::symmetric_tube_template(17);
    const Points vertices = tube.rest.skin_vertices.topRows(tube.num_wrap_vertices());
    const ControlPoints points = place_control_points(vertices, 7, 0.0);
    REQUIRE(points.size() == 7);
    for (int c = 0; c < points.size(); ++c) {
        const Eigen::RowVector3d point = vertices.row(points.vertices[c]);
        CHECK(point.x() >= 0);
        if (points.mirrored[c] < 0) {
            CHECK(point.x() < 0.02);
        } else {
            const Eigen::RowVector3d image = vertices.row(points.mirrored[c]);
            CHECK((image - point.cwiseProduct(Eigen::RowVector3d(-1, 1, 1))).norm() < 1e-12);
        }
    }
    const RowMatrix weights = control_point_weights(vertices, tube.wrap_triangles, points);
    REQUIRE(weights.cols() == 7);
    CHECK((weights.rowwise().sum().array() - 1).abs().maxCoeff() < 1e-12);
    CHECK(weights.minCoeff() >= 0);
    for (int c = 0; c < points.size(); ++c)
        for (const int v : {points.vertices[c], points.mirrored[c]})
            if (v >= 0) CHECK((weights.row(v) - Eigen::RowVectorXd::Unit(7, c)).norm() < 1e-12);
    // The same at a vertex and at the one opposite.
    for (Eigen::Index v = 0; v < vertices.rows(); ++v)
        for (Eigen::Index o = 0; o < vertices.rows(); ++o)
            if ((vertices.row(o).cwiseProduct(Eigen::RowVector3d(-1, 1, 1)) - vertices.row(v)).norm() < 1e-9)
                CHECK((weights.row(o) - weights.row(v)).cwiseAbs().maxCoeff() < 1e-8);
    CHECK_THROWS_WITH(place_control_points(vertices, 1000, 0.0), Catch::Contains("1000 control points"));
}

TEST_CASE("Where nothing is cut off, fields are biharmonic and level out at the boundary")
{
    // A narrow strip with values at its ends is a beam clamped there: the cubic 3 t^2 - 2 t^3.
    constexpr int length = 60;
    Points vertices(2 * length, 3);
    Triangles triangles(2 * (length - 1), 3);
    for (int i = 0; i < length; ++i) {
        vertices.row(2 * i) << 0, 0.1 * i, 0;
        vertices.row(2 * i + 1) << 0.1, 0.1 * i, 0;
        if (i + 1 == length) continue;
        triangles.row(2 * i) << 2 * i, 2 * i + 1, 2 * i + 2;
        triangles.row(2 * i + 1) << 2 * i + 1, 2 * i + 3, 2 * i + 2;
    }
    ControlPoints points;
    points.vertices = {0, 2 * length - 2};
    points.mirrored = {1, 2 * length - 1};
    const RowMatrix weights = control_point_weights(vertices, triangles, points);
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
        const double t = vertices(v, 1) / (0.1 * (length - 1));
        CHECK(weights(v, 1) == Approx(t * t * (3 - 2 * t)).margin(2e-3));
    }
}
