// SPDX-License-Identifier: Apache-2.0
#include "geometry/shapes.h"
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/core/threads.h"
#include "ndg/geometry/closest_point.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

using namespace ndg;
using ndg::test::Surface;

namespace {

Eigen::Vector3d random_point(Random& random, double reach)
{
    const double x = random.uniform(-reach, reach);
    const double y = random.uniform(-reach, reach);
    const double z = random.uniform(-reach, reach);
    return {x, y, z};
}

}  // namespace

TEST_CASE("closest point on a triangle is no farther than any sampled point")
{
    Random random(31, "triangle");
    for (int trial = 0; trial < 50; ++trial) {
        const Eigen::Vector3d a = random_point(random, 1);
        const Eigen::Vector3d b = random_point(random, 1);
        const Eigen::Vector3d c = trial % 10 == 0 ? Eigen::Vector3d(0.3 * a + 0.7 * b) : random_point(random, 1);
        const Eigen::Vector3d point = random_point(random, 2);
        const ClosestPoint closest = closest_point_on_triangle(point, a, b, c);
        CHECK(closest.barycentric.sum() == Approx(1.0));
        CHECK(closest.barycentric.minCoeff() >= -1e-12);
        const Eigen::Vector3d rebuilt =
            closest.barycentric[0] * a + closest.barycentric[1] * b + closest.barycentric[2] * c;
        CHECK((rebuilt - closest.point).norm() < 1e-12);
        CHECK(closest.distance == Approx((point - closest.point).norm()));
        double sampled = std::numeric_limits<double>::infinity();
        constexpr int n = 60;
        for (int i = 0; i <= n; ++i) {
            for (int j = 0; j <= n - i; ++j) {
                const Eigen::Vector3d sample = (i * a + j * b + (n - i - j) * c) / n;
                sampled = std::min(sampled, (sample - point).norm());
            }
        }
        CHECK(closest.distance <= sampled + 1e-12);
        CHECK(closest.distance >= sampled - 0.1);
    }
    // A triangle shrunk to a point.
    CHECK(closest_point_on_triangle({0, 0, 1}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}).distance == Approx(1.0));
}

TEST_CASE("triangle tree finds what brute force finds")
{
    const Surface sphere = test::icosphere(1.0, 3);
    const TriangleTree tree(sphere.vertices, sphere.triangles);
    Random random(32, "tree");
    for (int trial = 0; trial < 300; ++trial) {
        const Eigen::Vector3d point = random_point(random, trial % 2 == 0 ? 1.2 : 5.0);
        double best = std::numeric_limits<double>::infinity();
        for (Eigen::Index t = 0; t < sphere.triangles.rows(); ++t) {
            best = std::min(best, closest_point_on_triangle(point, sphere.vertices.row(sphere.triangles(t, 0)),
                                                            sphere.vertices.row(sphere.triangles(t, 1)),
                                                            sphere.vertices.row(sphere.triangles(t, 2)))
                                      .distance);
        }
        const ClosestPoint found = tree.closest(point);
        REQUIRE(found.distance == Approx(best).margin(1e-14));
        Eigen::Vector3d rebuilt = Eigen::Vector3d::Zero();
        for (int corner = 0; corner < 3; ++corner) {
            rebuilt += found.barycentric[corner] *
                       sphere.vertices.row(sphere.triangles(found.triangle_idx, corner)).transpose();
        }
        REQUIRE((rebuilt - found.point).norm() < 1e-14);
    }
    // A vertex belongs to several triangles; the first of them is reported.
    const ClosestPoint at_vertex = tree.closest(sphere.vertices.row(0).transpose());
    CHECK(at_vertex.distance == 0.0);
    Eigen::Index first = 0;
    while ((sphere.triangles.row(first).array() != 0).all()) ++first;
    CHECK(at_vertex.triangle_idx == first);
}

TEST_CASE("triangle tree rejects what it cannot search")
{
    const Surface cube = test::cube();
    CHECK_THROWS_AS(TriangleTree(cube.vertices, Triangles(0, 3)), Error);
    Triangles wrong = cube.triangles;
    wrong(0, 0) = 8;
    CHECK_THROWS_AS(TriangleTree(cube.vertices, wrong), Error);
    const TriangleTree tree(cube.vertices, cube.triangles);
    CHECK_THROWS_AS(tree.closest({std::nan(""), 0, 0}), Error);
}

TEST_CASE("winding number is one inside and zero outside")
{
    const Surface cube = test::cube();
    Points queries(4, 3);
    queries << 0.5, 0.5, 0.5, 0.01, 0.99, 0.3, 1.01, 0.5, 0.5, -3, 2, 7;
    const Eigen::VectorXd numbers = winding_numbers(cube.vertices, cube.triangles, queries);
    CHECK(numbers[0] == Approx(1.0).epsilon(1e-13));
    CHECK(numbers[1] == Approx(1.0).epsilon(1e-13));
    CHECK(std::abs(numbers[2]) < 1e-13);
    CHECK(std::abs(numbers[3]) < 1e-13);
    // A cube without bottom seen from its centre: the missing face spans a sixth of the full angle.
    const Triangles open = cube.triangles.bottomRows(10);
    const Points centre = queries.topRows(1);
    CHECK(winding_numbers(cube.vertices, open, centre)[0] == Approx(5.0 / 6.0).epsilon(1e-13));

    const Surface sphere = test::icosphere(1.0, 3);
    Random random(33, "winding");
    Points points(200, 3);
    for (Eigen::Index i = 0; i < points.rows(); ++i) points.row(i) = random_point(random, 1.5).transpose();
    const Eigen::VectorXd inside = winding_numbers(sphere.vertices, sphere.triangles, points);
    const int threads = num_threads();
    set_num_threads(1);
    CHECK(winding_numbers(sphere.vertices, sphere.triangles, points) == inside);
    set_num_threads(threads);
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        const double radius = points.row(i).norm();
        if (radius < 0.98 || radius > 1.0) CHECK(inside[i] == Approx(radius < 1.0 ? 1.0 : 0.0).margin(1e-12));
    }
}

TEST_CASE("the sign of the distance is that of the winding number")
{
    // A sphere with deep dents: closest points on faces, edges and vertices, convex and concave.
    Surface star = test::icosphere(1.0, 3);
    for (Eigen::Index v = 0; v < star.vertices.rows(); ++v) {
        const Eigen::RowVector3d d = star.vertices.row(v);
        star.vertices.row(v) *=
            1.0 + 0.45 * std::sin(7.0 * d.x()) * std::cos(6.0 * d.y()) + 0.1 * std::sin(9.0 * d.z());
    }
    const TriangleTree tree(star.vertices, star.triangles);
    Random random(34, "sign");
    Points points(600, 3);
    for (Eigen::Index i = 0; i < points.rows(); ++i) points.row(i) = random_point(random, 1.5).transpose();
    const Eigen::VectorXd winding = winding_numbers(star.vertices, star.triangles, points);
    int on_vertices = 0, on_edges = 0;
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        ClosestPoint nearest;
        const double distance = tree.signed_distance(points.row(i).transpose(), &nearest);
        CHECK((distance < 0.0) == (winding[i] > 0.5));
        CHECK(std::abs(distance) == Approx(nearest.distance));
        const auto zeros = (nearest.barycentric.array() <= 0.0).count();
        on_edges += zeros == 1;
        on_vertices += zeros == 2;
    }
    CHECK(on_edges > 30);
    CHECK(on_vertices > 30);
}
