// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/cut_away.h"

#include "scene/shapes.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <set>

using namespace ndg;

namespace {

double surface_area(const SceneSurface& surface)
{
    double area = 0;
    for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
        const Eigen::RowVector3d a = surface.vertices.row(surface.triangles(t, 0));
        area += 0.5 * (surface.vertices.row(surface.triangles(t, 1)) - a)
                          .cross(surface.vertices.row(surface.triangles(t, 2)) - a)
                          .norm();
    }
    return area;
}

}  // namespace

TEST_CASE("Of a cut surface stays what lies behind the plane, as it was")
{
    SceneSurface ball = test::sphere("ball", 0.5, 4, {1, 0, 0});
    ball.vertex_colours = ball.vertices.cast<float>().array() + 0.5f;  // a colour that tells where it is
    const double height = 0.2;
    const ClipPlane plane{{0, 0, height}, {0, 0, 2}};  // the normal need not be of length 1
    const SceneSurface cut = cut_surface(ball, plane);
    CHECK_NOTHROW(check_surface(cut));
    std::set<int> used;
    for (Eigen::Index t = 0; t < cut.triangles.rows(); ++t)
        for (int k = 0; k < 3; ++k) used.insert(cut.triangles(t, k));
    double highest = -1;
    for (const int v : used) {
        highest = std::max(highest, cut.vertices(v, 2));
        CHECK((cut.vertex_colours.row(v) - (cut.vertices.row(v).cast<float>().array() + 0.5f).matrix()).norm() < 1e-5f);
    }
    CHECK(highest == Approx(height));
    // Archimedes: the cap above has the area 2 pi r (r - h); the rest of the tessellated ball loses as much.
    CHECK(surface_area(ball) - surface_area(cut) == Approx(2 * M_PI * 0.5 * (0.5 - height)).epsilon(0.01));
    CHECK(cut_surface(ball, {{0, 0, 1}, {0, 0, 1}}).triangles == ball.triangles);
    CHECK(cut_surface(ball, {{0, 0, -1}, {0, 0, 1}}).triangles.rows() == 0);
}

TEST_CASE("The cut face of prisms fills the ring between their wraps and faces what was cut away")
{
    const Template tube = test::tube_template(7, 8);
    const int fat = tube.num_prisms() - tube.fat_begin(), num_wrap = tube.num_wrap_vertices();
    const Points& vertices = tube.rest.volume_vertices;
    const double middle = 0.5 * (vertices.col(1).minCoeff() + vertices.col(1).maxCoeff()) + 0.013;
    const Eigen::Vector3d normal(0, 1, 0);
    const SceneSurface face = cut_face(vertices, tube.prisms.bottomRows(fat), {{0, middle, 0}, normal});
    REQUIRE(face.triangles.rows() > 0);
    CHECK((face.vertices.col(1).array() - middle).abs().maxCoeff() < 1e-12);
    for (Eigen::Index t = 0; t < face.triangles.rows(); ++t) {
        const Eigen::RowVector3d a = face.vertices.row(face.triangles(t, 0));
        const Eigen::RowVector3d b = face.vertices.row(face.triangles(t, 1)),
                                 c = face.vertices.row(face.triangles(t, 2));
        CHECK((b - a).cross(c - a).dot(normal.transpose()) >= 0);
    }
    // Wraps are regular octagons: 2 sqrt(2) r^2 of circumradius r.
    const auto radius = [&](int wrap) {
        return vertices.row(wrap * num_wrap).cwiseProduct(Eigen::RowVector3d(1, 0, 1)).norm();
    };
    const double ring = 2 * std::sqrt(2.0) * (radius(2) * radius(2) - radius(1) * radius(1));
    CHECK(surface_area(face) == Approx(ring).epsilon(1e-6));
    const SceneSurface missed = cut_face(vertices, tube.prisms.bottomRows(fat), {{0, 100, 0}, normal});
    CHECK(missed.triangles.rows() == 0);
}

TEST_CASE("A cut-away shows the inside on the plane's side and the skin on the other")
{
    const Template tube = test::tube_template(7, 16);
    const BodyGeometry geometry = rest_geometry(tube, tube.rest);
    RenderSettings settings;
    settings.width = settings.height = 120;
    settings.lit = false;
    const Camera camera = frame_points(geometry.skin_vertices, view_direction(View::front), 1.0);
    const auto shown = [&](const Eigen::Vector3d& normal) {
        return render(cut_away_surfaces(tube, geometry, {Eigen::Vector3d::Zero(), normal}), camera, settings);
    };
    const Pixel skin = pixel_from_linear(linear_from_srgb(skin_surface(tube, geometry).colour));
    const auto count_skin = [&](const Image& image, bool right_half) {
        int count = 0;
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < image.width / 2; ++x)
                count += image.at(right_half ? x + image.width / 2 : x, y) == skin;
        return count;
    };
    const Image whole = render({skin_surface(tube, geometry)}, camera, settings);
    const int half = count_skin(whole, false);
    REQUIRE(half > 300);
    // The body's left, +x, is on the right of a front view.
    const Image left_open = shown(Eigen::Vector3d::UnitX()), right_open = shown(-Eigen::Vector3d::UnitX());
    CHECK(count_skin(left_open, false) > 0.95 * half);
    CHECK(count_skin(left_open, true) < 0.02 * half);
    CHECK(count_skin(right_open, true) > 0.95 * half);
    CHECK(count_skin(right_open, false) < 0.02 * half);
    // In front of a frontal plane nothing but the inside is left, and no other colours than those of the inside.
    const Image open = shown(Eigen::Vector3d::UnitZ());
    int inside = 0;
    for (const SceneSurface& surface :
         cut_away_surfaces(tube, geometry, {Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ()}))
        if (surface.name != "skin")
            inside += test::count_pixels(open, pixel_from_linear(linear_from_srgb(surface.colour)));
    CHECK(inside > 300);
}
