// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/section.h"

#include "ndg/geometry/triangle_mesh.h"
#include "scene/shapes.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;
using ndg::test::count_pixels;
using ndg::test::sphere;

TEST_CASE("A sphere is cut in a circle that runs with the inside to its left")
{
    const SceneSurface ball = sphere("ball", 0.5, 5, {1, 0, 0});
    SectionPlane plane;
    plane.origin = {0.05, 0.02, 0.3};
    const std::vector<SectionSegment> segments = section_segments(ball.vertices, ball.triangles, plane);
    REQUIRE(!segments.empty());
    double area = 0, length = 0;
    for (const SectionSegment& segment : segments) {
        area += 0.5 * (segment.begin.x() * segment.end.y() - segment.end.x() * segment.begin.y());
        length += (segment.end - segment.begin).norm();
        CHECK((segment.begin + Eigen::Vector2d(0.05, 0.02)).norm() == Approx(0.4).epsilon(3e-3));
    }
    CHECK(area == Approx(M_PI * 0.16).epsilon(0.01));  // positive: counter-clockwise
    CHECK(length == Approx(2 * M_PI * 0.4).epsilon(0.01));
    plane.origin.z() = 0.6;
    CHECK(section_segments(ball.vertices, ball.triangles, plane).empty());
    // Through vertices: the equator of the octahedron.
    plane.origin.setZero();
    double equator = 0;
    for (const SectionSegment& segment : section_segments(ball.vertices, ball.triangles, plane))
        equator += 0.5 * (segment.begin.x() * segment.end.y() - segment.end.x() * segment.begin.y());
    CHECK(equator == Approx(M_PI * 0.25).epsilon(0.01));
}

TEST_CASE("Sections are filled surface over surface")
{
    SectionSettings settings;
    settings.width = settings.height = 300;
    settings.pixels_per_metre = 250;
    settings.line_width = 0;
    settings.background = {1, 1, 1};
    const std::vector<SceneSurface> surfaces = {sphere("outer", 0.5, 5, {1, 0, 0}),
                                                sphere("inner", 0.25, 5, {0, 0, 1})};
    const Image image = section_image(surfaces, {}, settings);
    CHECK(image.at(150, 150) == Pixel{0, 0, 255});
    CHECK(image.at(150 + 95, 150) == Pixel{255, 0, 0});
    CHECK(image.at(5, 5) == Pixel{255, 255, 255});
    const double pixel_area = 1.0 / (250.0 * 250.0);
    CHECK(count_pixels(image, {0, 0, 255}) * pixel_area == Approx(M_PI * 0.0625).epsilon(0.04));
    CHECK(count_pixels(image, {255, 0, 0}) * pixel_area == Approx(M_PI * (0.25 - 0.0625)).epsilon(0.04));
}

TEST_CASE("A surface with holes is closed by fans and keeps its orientation")
{
    SceneSurface ball = sphere("ball", 0.5, 3, {1, 0, 0});
    std::vector<int> kept;
    for (int t = 0; t < int(ball.triangles.rows()); ++t) {
        bool inside = true;
        for (int k = 0; k < 3; ++k) inside = inside && std::abs(ball.vertices(ball.triangles(t, k), 1)) < 0.4;
        if (inside) kept.push_back(t);
    }
    Triangles open(Eigen::Index(kept.size()), 3);
    for (std::size_t i = 0; i < kept.size(); ++i) open.row(Eigen::Index(i)) = ball.triangles.row(kept[i]);
    ball.triangles = open;
    REQUIRE(boundary_loops(ball.triangles, int(ball.vertices.rows())).size() == 2);
    const SceneSurface closed = closed_surface(ball);
    CHECK(boundary_loops(closed.triangles, int(closed.vertices.rows())).empty());
    CHECK(closed.vertices.rows() == ball.vertices.rows() + 2);
    for (const MeshEdge& edge : mesh_edges(closed.triangles, int(closed.vertices.rows())))
        CHECK(edge.right_triangle >= 0);
    CHECK(enclosed_volume(closed.vertices, closed.triangles) > 0.3);
    const SceneSurface untouched = closed_surface(sphere("ball", 0.5, 2, {1, 0, 0}));
    CHECK(untouched.triangles.rows() == 128);
}
