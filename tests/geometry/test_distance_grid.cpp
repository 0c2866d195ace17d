// SPDX-License-Identifier: Apache-2.0
// Distance fields on grids against shapes whose distance is known.
#include "ndg/core/error.h"
#include "ndg/geometry/distance_grid.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <vector>

using namespace ndg;
using Catch::Matchers::Contains;

namespace {

struct Soup {
    Points vertices;
    Triangles triangles;
};

/// A sphere of rings and sectors, outward.
Soup sphere(const Eigen::Vector3d& centre, double radius, int rings = 40, int sectors = 80)
{
    Soup soup{Points((rings + 1) * sectors, 3), Triangles(2 * rings * sectors, 3)};
    int t = 0;
    for (int r = 0; r <= rings; ++r)
        for (int s = 0; s < sectors; ++s) {
            const double polar = M_PI * r / rings, around = 2.0 * M_PI * s / sectors;
            soup.vertices.row(r * sectors + s) =
                centre.transpose() + radius * Eigen::RowVector3d(std::sin(polar) * std::cos(around), std::cos(polar),
                                                                 -std::sin(polar) * std::sin(around));
            if (r == rings) continue;
            const int a = r * sectors + s, b = r * sectors + (s + 1) % sectors;
            soup.triangles.row(t++) << a, a + sectors, b;
            soup.triangles.row(t++) << b, a + sectors, b + sectors;
        }
    return soup;
}

Soup together(const Soup& a, const Soup& b)
{
    Soup soup{Points(a.vertices.rows() + b.vertices.rows(), 3), Triangles(a.triangles.rows() + b.triangles.rows(), 3)};
    soup.vertices << a.vertices, b.vertices;
    soup.triangles << a.triangles, Triangles(b.triangles.array() + static_cast<int>(a.vertices.rows()));
    return soup;
}

}  // namespace

TEST_CASE("distance grid: a sphere's signed distance, near and far, inside and outside")
{
    const Eigen::Vector3d centre(0.01, -0.02, 0.03);
    const Soup ball = sphere(centre, 0.06);
    const GridBox box = grid_around(ball.vertices, 0.05, 0.004);
    const ScalarGrid grid = signed_distance_grid(box, ball.vertices, ball.triangles);
    double worst_near = 0.0, worst_far = 0.0, total = 0.0;
    int count = 0;
    for (int k = 0; k < box.size[2]; k += 2)
        for (int j = 0; j < box.size[1]; j += 2)
            for (int i = 0; i < box.size[0]; i += 2) {
                const Eigen::Vector3d node = box.node(i, j, k);
                const double expected = (node - centre).norm() - 0.06;
                double& worst = std::abs(expected) < 0.0115 ? worst_near : worst_far;
                worst = std::max(worst, std::abs(grid.at(node) - expected));
                total += std::abs(grid.at(node) - expected);
                ++count;
            }
    CHECK(worst_near < 0.00015);  // the facets themselves are 0.1 mm off
    CHECK(worst_far < 0.4 * 0.004);
    CHECK(total / count < 0.04 * 0.004 + 0.0001);
}

TEST_CASE("distance grid: an open surface has an inside as far as its normals say")
{
    // a square in the plane y = 0 that faces up
    Points vertices(4, 3);
    vertices << -0.05, 0, -0.05, 0.05, 0, -0.05, 0.05, 0, 0.05, -0.05, 0, 0.05;
    Triangles triangles(2, 3);
    triangles << 0, 2, 1, 0, 3, 2;
    const ScalarGrid grid = signed_distance_grid(grid_around(vertices, 0.03, 0.005), vertices, triangles);
    CHECK(grid.at({0.011, 0.013, -0.007}) == Approx(0.013).margin(2e-4));
    CHECK(grid.at({0.011, -0.013, -0.007}) == Approx(-0.013).margin(2e-4));
    CHECK(grid.at({0.0, 0.002, 0.0}) == Approx(0.002).margin(1e-6));
}

TEST_CASE("distance grid: the gradient is that of the interpolation, also beyond the grid")
{
    const Soup ball = sphere({0, 0, 0}, 0.05, 12, 20);
    const ScalarGrid grid =
        signed_distance_grid(grid_around(ball.vertices, 0.01, 0.006), ball.vertices, ball.triangles);
    const double step = 1e-7;
    for (const Eigen::Vector3d& point : {Eigen::Vector3d(0.021, 0.013, -0.034), Eigen::Vector3d(0.002, -0.051, 0.004),
                                         Eigen::Vector3d(0.2, 0.01, 0.02)}) {
        Eigen::Vector3d gradient;
        grid.at(point, &gradient);
        for (int axis = 0; axis < 3; ++axis) {
            const Eigen::Vector3d shift = step * Eigen::Vector3d::Unit(axis);
            CHECK((grid.at(point + shift) - grid.at(point - shift)) / (2.0 * step) ==
                  Approx(gradient[axis]).margin(1e-6));
        }
    }
}

TEST_CASE("distance grid: closing of two balls has the neck that a rolling ball leaves")
{
    constexpr double ball_radius = 0.03, apart = 0.08, rolling = 0.04, spacing = 0.0025;
    const Soup pair = together(sphere({-apart / 2, 0, 0}, ball_radius), sphere({apart / 2, 0, 0}, ball_radius));
    const ScalarGrid closed = closing_grid(grid_around(pair.vertices, rolling + 3 * spacing, spacing), pair.vertices,
                                           pair.triangles, rolling);
    // The rolling ball touches both: its centre is this far from the axis, in the middle between them.
    const double centre = std::sqrt(std::pow(ball_radius + rolling, 2) - std::pow(apart / 2, 2));
    const double neck = centre - rolling;
    REQUIRE(neck > 0.01);
    for (const double angle : {0.1, 1.3, 4.0}) {
        const Eigen::Vector3d outwards(0.0, std::cos(angle), std::sin(angle));
        // The crease that the ball's centre runs along falls between the nodes.
        CHECK(closed.at((neck + 0.004) * outwards) == Approx(0.004).margin(0.4 * spacing));
        CHECK(closed.at((neck - 0.004) * outwards) == Approx(-0.004).margin(0.4 * spacing));
    }
    CHECK(closed.at({apart / 2 + ball_radius + 0.006, 0, 0}) == Approx(0.006).margin(4e-4));
    // The inside of a closed surface is no cavity.
    CHECK(closed.at({apart / 2, 0, 0}) < -0.015);

    // A ball that fits between them closes nothing.
    constexpr double small = 0.006;
    const ScalarGrid open =
        closing_grid(grid_around(pair.vertices, small + 3 * spacing, spacing), pair.vertices, pair.triangles, small);
    CHECK(open.at({0.005, 0, 0}) == Approx(apart / 2 - ball_radius - 0.005).margin(4e-4));
}

TEST_CASE("distance grid: the closing does not mind doubled, flipped and missing triangles")
{
    constexpr double spacing = 0.003, radius = 0.01;
    const Soup ball = sphere({0, 0, 0}, 0.04);
    Soup damaged = together(ball, ball);
    std::vector<Eigen::Index> keep;
    for (Eigen::Index t = 0; t < damaged.triangles.rows(); ++t) {
        if (t % 3 == 0) damaged.triangles.row(t).reverseInPlace();
        if (t % 7 != 0) keep.push_back(t);
    }
    Triangles kept(static_cast<Eigen::Index>(keep.size()), 3);
    for (std::size_t t = 0; t < keep.size(); ++t)
        kept.row(static_cast<Eigen::Index>(t)) = damaged.triangles.row(keep[t]);
    const GridBox box = grid_around(ball.vertices, radius + 3 * spacing, spacing);
    const ScalarGrid good = closing_grid(box, ball.vertices, ball.triangles, radius);
    const ScalarGrid bad = closing_grid(box, damaged.vertices, kept, radius);
    double worst = 0.0;
    for (std::size_t n = 0; n < good.values.size(); ++n)
        worst = std::max(worst, double(std::abs(good.values[n] - bad.values[n])));
    CHECK(worst < 0.0006);
}

TEST_CASE("distance grid: what cannot be done is refused")
{
    const Soup ball = sphere({0, 0, 0}, 0.04, 8, 12);
    GridBox away = grid_around(ball.vertices, 0.01, 0.005);
    away.origin.x() += 10.0;
    CHECK_THROWS_WITH(signed_distance_grid(away, ball.vertices, ball.triangles), Contains("no triangle reaches"));
    CHECK_THROWS_WITH(closing_grid(grid_around(ball.vertices, 0.0, 0.005), ball.vertices, ball.triangles, 0.5),
                      Contains("too small for a closing"));
    CHECK_THROWS_WITH(grid_around(ball.vertices, 0.0, 1e-6), Contains("too large"));
}
