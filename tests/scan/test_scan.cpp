// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/scan/scan.h"
#include "ndg/scan/scan_cut.h"
#include "ndg/scan/scan_normals.h"
#include "ndg/scan/scan_simulation.h"
#include "scan/template_skin.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;

namespace {

/// Points on the ellipsoid with these half axes.
Points ellipsoid(int count, const Eigen::RowVector3d& half_axes)
{
    Random random(3, "ellipsoid");
    Points points(count, 3);
    for (int i = 0; i < count; ++i) {
        Eigen::RowVector3d p;
        for (int k = 0; k < 3; ++k) p[k] = random.normal();
        points.row(i) = p.normalized().cwiseProduct(half_axes);
    }
    return points;
}

}  // namespace

TEST_CASE("normals of a point cloud point outwards")
{
    const Eigen::RowVector3d axes(0.3, 0.85, 0.2);
    const Points points = ellipsoid(4000, axes);
    const Points normals = estimate_normals(points, PointTree(points), 24, Points(0, 3));
    int right = 0;
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        const Eigen::RowVector3d exact = points.row(i).cwiseQuotient(axes.cwiseAbs2()).normalized();
        right += normals.row(i).dot(exact) > 0.95;
    }
    CHECK(right > 3900);
}

TEST_CASE("unit and possible up axes are guessed from the extents")
{
    const Points person = ellipsoid(3000, {0.3, 0.85, 0.2});
    for (const auto& [unit, unused] : enum_table<LengthUnit>) {
        const ScanPoints scan = prepare_scan("scan", person / metres_of_unit(unit), Triangles(0, 3), {});
        CHECK(scan.unit == unit);
        CHECK(scan.up_axes == std::vector<Axis>{Axis::y, Axis::minus_y});
        CHECK(scan.points.col(1).maxCoeff() == Approx(0.85).margin(0.02));
    }
    ScanOptions few;
    few.max_points = 2000;
    const ScanPoints thinned = prepare_scan("scan", ellipsoid(30000, {0.3, 0.85, 0.2}), Triangles(0, 3), few);
    CHECK(thinned.points.rows() > 1200);
    CHECK(thinned.points.rows() <= 2400);
    for (const std::string up : {"x", "y", "z", "-x", "-y", "-z"}) {
        const Eigen::Matrix3d rotation = rotation_to_y_up(parse_name<Axis>(up));
        Eigen::Vector3d axis = Eigen::Vector3d::Zero();
        axis[up.back() - 'x'] = up[0] == '-' ? -1.0 : 1.0;
        CHECK((rotation * axis - Eigen::Vector3d::UnitY()).norm() < 1e-12);
        CHECK(rotation.determinant() == Approx(1.0));
    }
}

TEST_CASE("what is no scan of a person is refused")
{
    const Points person = ellipsoid(3000, {0.3, 0.85, 0.2});
    const Triangles none(0, 3);
    CHECK_THROWS_AS(prepare_scan("scan", 0.5 * person, none, {}), InputError);  // half a person, in no unit
    CHECK_THROWS_AS(prepare_scan("scan", person.topRows(100), none, {}), InputError);
    CHECK_THROWS_AS(prepare_scan("scan", Points(0, 3), none, {}), InputError);
    Points broken = person;
    broken(7, 1) = std::nan("");
    CHECK_THROWS_AS(prepare_scan("scan", broken, none, {}), InputError);
    ScanOptions millimetres;
    millimetres.unit = LengthUnit::millimetre;
    CHECK_THROWS_AS(prepare_scan("scan", person, none, millimetres), InputError);
    CHECK_THROWS_AS(prepare_scan("scan", Points::Zero(3000, 3), none, {}), InputError);
}

TEST_CASE("coordinates that are no places on a person are refused at once")
{
    const SkinnedSurface& skin = test::template_skin();
    for (const double far : {1e8, -1e30, 1e300}) {
        Points vertices = skin.vertices;
        vertices(vertices.rows() / 2, 1) = far;
        CHECK_THROWS_WITH(prepare_scan("scan", vertices, skin.triangles, {}), Catch::Contains("no place on a person"));
    }
}

TEST_CASE("a floor is found and cut away, a person's own surface never")
{
    const SkinnedSurface& skin = test::template_skin();
    CHECK(!find_floor(skin.vertices));
    ScanSimulationOptions options;
    options.fault = ScanFault::floor;
    const SimulatedScan simulated = simulate_scan(skin, options, 5, 1);
    // Tilted, in another unit, as mesh and as cloud.
    const Points file = 1000.0 * simulated.scan.vertices * Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX()).matrix();
    const auto floor = find_floor(file);
    REQUIRE(floor);
    CHECK(std::abs(floor->normal.dot(Eigen::AngleAxisd(-0.1, Eigen::Vector3d::UnitX()) * Eigen::Vector3d::UnitY())) >
          0.9999);
    CHECK(floor->normal[1] > 0);
    const TriangleTree tree(simulated.posed_skin, skin.triangles);
    for (const bool cloud : {false, true}) {
        const ScanPoints scan =
            prepare_scan("scan", simulated.scan.vertices, cloud ? Triangles(0, 3) : simulated.scan.triangles, {});
        CHECK(scan.up_axes == std::vector<Axis>{Axis::y});
        CHECK(scan.notes.size() >= 2);
        // Floor and box are gone, the feet are not.
        CHECK(scan.points.col(1).minCoeff() < simulated.posed_skin.col(1).minCoeff() + 0.02);
        for (Eigen::Index i = 0; i < scan.points.rows(); i += 41) {
            CHECK(tree.closest(scan.points.row(i).transpose()).distance < 0.012);
        }
    }
}

TEST_CASE("parts of a scan are turned outwards one by one")
{
    const SkinnedSurface& skin = test::template_skin();
    ScanSimulationOptions options;
    options.noise = 0.0;
    for (const ScanFault fault : {ScanFault::none, ScanFault::pieces, ScanFault::mirrored}) {
        options.fault = fault;
        const SimulatedScan simulated = simulate_scan(skin, options, 5, 1);
        const ScanPoints scan = prepare_scan("scan", simulated.scan.vertices, simulated.scan.triangles, {});
        Triangles outward = skin.triangles;
        if (fault == ScanFault::mirrored) outward.col(1).swap(outward.col(2));
        const TriangleTree tree(simulated.posed_skin, outward);
        const Points normals = triangle_normals(simulated.posed_skin, outward);
        int wrong = 0;
        for (Eigen::Index i = 0; i < scan.points.rows(); ++i) {
            const ClosestPoint closest = tree.closest(scan.points.row(i).transpose());
            wrong += scan.normals.row(i).dot(normals.row(closest.triangle_idx)) < 0;
        }
        INFO(to_name(fault));
        CHECK(wrong < 0.002 * static_cast<double>(scan.points.rows()));
        CHECK(scan.notes.empty() == (fault == ScanFault::none));
    }
}

TEST_CASE("large triangles are surface, not holes")
{
    const SkinnedSurface& skin = test::template_skin();
    ScanSimulationOptions options;
    options.fault = ScanFault::large_triangles;
    options.hole_radius = 0.0;
    const SimulatedScan simulated = simulate_scan(skin, options, 5, 1);
    const ScanPoints scan = prepare_scan("scan", simulated.scan.vertices, simulated.scan.triangles, {});
    const PointTree tree(scan.points);
    double farthest = 0.0;
    for (Eigen::Index v = 0; v < skin.vertices.rows(); ++v) {
        farthest = std::max(farthest, tree.nearest(simulated.posed_skin.row(v).transpose()).squared_distance);
    }
    CHECK(std::sqrt(farthest) < 0.025);
}

TEST_CASE("a simulated scan lies on the posed skin and depends on seed and body alone")
{
    const SkinnedSurface& skin = test::template_skin();
    ScanSimulationOptions options;
    options.points = 8000;
    options.noise = 0.0;
    const SimulatedScan a = simulate_scan(skin, options, 5, 2), b = simulate_scan(skin, options, 5, 2);
    CHECK(a.scan.vertices == b.scan.vertices);
    CHECK(a.scan.triangles == b.scan.triangles);
    CHECK(simulate_scan(skin, options, 5, 3).posed_skin != a.posed_skin);
    CHECK(a.scan.vertices.rows() > 4000);
    // Far fewer closed places than the skin has: a hole's rim at armpits, crotch, soles and head.
    CHECK(boundary_loops(a.scan.triangles, static_cast<int>(a.scan.vertices.rows())).size() >= 4);
    const TriangleTree tree(a.posed_skin, skin.triangles);
    for (Eigen::Index i = 0; i < a.scan.vertices.rows(); i += 37) {
        CHECK(tree.closest(a.scan.vertices.row(i).transpose()).distance < 1e-9);
    }
    options.noise = 0.002;
    options.cloud = true;
    const SimulatedScan noisy = simulate_scan(skin, options, 5, 2);
    CHECK(noisy.scan.triangles.rows() == 0);
    double squares = 0.0;
    for (Eigen::Index i = 0; i < noisy.scan.vertices.rows(); ++i) {
        squares += std::pow(tree.closest(noisy.scan.vertices.row(i).transpose()).distance, 2);
    }
    CHECK(std::sqrt(squares / double(noisy.scan.vertices.rows())) == Approx(0.002).epsilon(0.1));
}
