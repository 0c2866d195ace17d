// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/render.h"

#include "ndg/core/error.h"
#include "ndg/core/hash.h"
#include "ndg/core/threads.h"
#include "ndg/scene/occlusion.h"
#include "scene/shapes.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;
using ndg::test::sphere;
using ndg::test::square;

namespace {

/// Parallel camera from +z on the square [-1, 1]^2.
Camera front_camera()
{
    Camera camera;
    camera.position = {0, 0, 5};
    camera.right = Eigen::Vector3d::UnitX();
    camera.up = Eigen::Vector3d::UnitY();
    camera.backward = Eigen::Vector3d::UnitZ();
    camera.image_height = 2.0;
    return camera;
}

/// Colours as they are on white.
RenderSettings unlit(int size)
{
    RenderSettings settings;
    settings.width = settings.height = size;
    settings.lit = false;
    settings.background = {1, 1, 1};
    return settings;
}

const Eigen::Vector3f red(1, 0, 0), blue(0, 0, 1), black(0, 0, 0);
const Pixel white_pixel = {255, 255, 255}, red_pixel = {255, 0, 0}, blue_pixel = {0, 0, 255};

std::string image_hash(const Image& image)
{
    return sha256({reinterpret_cast<const char*>(image.pixels.data()), image.pixels.size() * sizeof(Pixel)});
}

}  // namespace

TEST_CASE("The silhouette of a sphere has the area of its disc")
{
    const double radius = 0.7;
    RenderSettings settings = unlit(300);
    settings.samples_per_axis = 3;
    const Image image = render({sphere("ball", radius, 5, black)}, front_camera(), settings);
    double covered = 0;
    for (const Pixel& pixel : image.pixels) covered += 1.0 - double(linear_from_srgb(float(pixel[0]) / 255.0f));
    const double area = covered * 4.0 / (300.0 * 300.0);
    CHECK(area == Approx(M_PI * radius * radius).epsilon(0.01));

    Camera perspective = front_camera();
    perspective.perspective = true;
    perspective.image_height = 0.4;  // 5 m away: 2 m at the centre
    const Image seen = render({sphere("ball", radius, 5, black)}, perspective, settings);
    covered = 0;
    for (const Pixel& pixel : seen.pixels) covered += 1.0 - double(linear_from_srgb(float(pixel[0]) / 255.0f));
    // The tangent cone has half angle asin(r / d): a disc of radius d tan(...) in the plane through the centre.
    const double disc = 5.0 * std::tan(std::asin(radius / 5.0));
    CHECK(covered * 4.0 / (300.0 * 300.0) == Approx(M_PI * disc * disc).epsilon(0.01));
}

TEST_CASE("The layer in front hides the one behind, whatever their order in the list")
{
    const Layer near = square("near", 0.5, 1.0, red), far = square("far", 0.5, 0.0, blue);
    for (const bool reversed : {false, true}) {
        const std::vector<Layer> layers = reversed ? std::vector<Layer>{far, near} : std::vector<Layer>{near, far};
        const Image image = render(layers, front_camera(), unlit(40));
        CHECK(image.at(20, 20) == red_pixel);
        CHECK(image.at(2, 2) == white_pixel);
        Camera behind = front_camera();
        behind.position.z() = -5;
        behind.right *= -1;
        behind.backward *= -1;
        CHECK(render(layers, behind, unlit(40)).at(20, 20) == blue_pixel);
    }
}

TEST_CASE("The image is upright: up is the top row, right the last column")
{
    Layer corner = square("corner", 0.2, 0.0, red);
    corner.vertices.rowwise() += Eigen::RowVector3d(0.7, 0.7, 0);
    const Image image = render({corner}, front_camera(), unlit(40));
    CHECK(image.at(34, 5) == red_pixel);
    CHECK(image.at(34, 34) == white_pixel);
    CHECK(image.at(5, 5) == white_pixel);
}

TEST_CASE("Translucent layers blend front to back in linear light")
{
    Layer near = square("near", 0.5, 1.0, red), far = square("far", 0.5, 0.0, blue);
    near.opacity = 0.5f;
    const auto encoded = [](double linear) {
        return int(std::lround(255.0 * double(srgb_from_linear(float(linear)))));
    };
    const Pixel over_opaque = render({near, far}, front_camera(), unlit(40)).at(20, 20);
    CHECK(int(over_opaque[0]) == encoded(0.5));
    CHECK(int(over_opaque[1]) == 0);
    CHECK(int(over_opaque[2]) == encoded(0.5));
    CHECK(encoded(0.5) == 188);  // sRGB of half the light

    far.opacity = 0.25f;
    // 0.5 red, then 0.5 * 0.25 blue, then 0.5 * 0.75 of the white behind.
    const Pixel over_background = render({near, far}, front_camera(), unlit(40)).at(20, 20);
    CHECK(int(over_background[0]) == encoded(0.5 + 0.375));
    CHECK(int(over_background[1]) == encoded(0.375));
    CHECK(int(over_background[2]) == encoded(0.125 + 0.375));
}

TEST_CASE("A one-sided layer is not seen from behind")
{
    Layer layer = square("sheet", 0.5, 0.0, red);
    layer.two_sided = false;
    CHECK(render({layer}, front_camera(), unlit(20)).at(10, 10) == red_pixel);
    layer.triangles.col(1).swap(layer.triangles.col(2));
    CHECK(render({layer}, front_camera(), unlit(20)).at(10, 10) == white_pixel);
    layer.two_sided = true;
    CHECK(render({layer}, front_camera(), unlit(20)).at(10, 10) == red_pixel);
}

TEST_CASE("A layer that shows its outermost surface only lets nothing of itself through")
{
    Layer shell = sphere("shell", 0.8, 3, red);
    const Layer inner = sphere("shell", 0.4, 3, red);
    const Eigen::Index vertices = shell.vertices.rows(), triangles = shell.triangles.rows();
    shell.vertices.conservativeResize(2 * vertices, 3);
    shell.vertices.bottomRows(vertices) = inner.vertices;
    shell.triangles.conservativeResize(2 * triangles, 3);
    shell.triangles.bottomRows(triangles) = inner.triangles.array() + int(vertices);
    shell.opacity = 0.5f;
    // The centre ray meets four surfaces, the ring around the inner ball two.
    const Image all = render({shell}, front_camera(), unlit(41));
    CHECK(int(all.at(20, 20)[1]) == int(pixel_from_linear({1, 0.0625f, 0.0625f})[1]));
    CHECK(int(all.at(20, 8)[1]) == int(pixel_from_linear({1, 0.25f, 0.25f})[1]));
    shell.outermost_only = true;
    const Image outermost = render({shell}, front_camera(), unlit(41));
    CHECK(int(outermost.at(20, 20)[1]) == int(pixel_from_linear({1, 0.5f, 0.5f})[1]));
    CHECK(outermost.at(20, 8) == outermost.at(20, 20));
}

TEST_CASE("A clip plane cuts away what lies on its normal's side")
{
    const std::vector<Layer> layers = {square("near", 0.9, 1.0, red), square("far", 0.9, 0.0, blue)};
    RenderSettings settings = unlit(40);
    settings.clip = ClipPlane{{0, 0, 0.5}, {0, 0, 1}};
    CHECK(render(layers, front_camera(), settings).at(20, 20) == blue_pixel);
    settings.clip = ClipPlane{{0, 0, 0.5}, {0, 0, -1}};
    CHECK(render(layers, front_camera(), settings).at(20, 20) == red_pixel);
    settings.clip = ClipPlane{{0, 0, 0}, {1, 0, 0}};
    const Image half = render(layers, front_camera(), settings);
    CHECK(half.at(10, 20) == red_pixel);
    CHECK(half.at(30, 20) == white_pixel);
    // Oblique: near layer gone where x + z > 1, i.e. right of the middle at z = 1.
    settings.clip = ClipPlane{{0, 0, 1}, Eigen::Vector3d(1, 0, 1).normalized()};
    const Image oblique = render(layers, front_camera(), settings);
    CHECK(oblique.at(10, 20) == red_pixel);
    CHECK(oblique.at(30, 20) == blue_pixel);
}

TEST_CASE("Vertex colours are interpolated")
{
    Layer layer = square("sheet", 1.0, 0.0, black);
    layer.vertex_colours.resize(4, 3);
    layer.vertex_colours << 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0;  // black left, red right
    const Image image = render({layer}, front_camera(), unlit(64));
    const double middle = double(linear_from_srgb(float(image.at(32, 20)[0]) / 255.0f));
    CHECK(middle == Approx(32.5 / 64.0).margin(0.01));
    CHECK(image.at(0, 32)[0] < image.at(63, 32)[0]);
}

TEST_CASE("Half the sky over a point at the foot of a high wall is open")
{
    Layer wall = square("wall", 50.0, 0.0, red);
    const RayTracer tracer({wall});
    const double open = double(openness(tracer, {0, 0, 0.001}, Eigen::Vector3d::UnitY(), 4096, 1000.0, 7, {}));
    CHECK(open == Approx(0.5).margin(0.02));
    // Nothing within reach: all open. Translucent layers do not count.
    CHECK(openness(tracer, {0, 0, 2.0}, Eigen::Vector3d::UnitY(), 64, 1.0, 7, {}) == 1.0f);
    wall.opacity = 0.5f;
    CHECK(openness(RayTracer({wall}), {0, 0, 0.001}, Eigen::Vector3d::UnitY(), 64, 1000.0, 7, {}) == 1.0f);
}

TEST_CASE("Lit pictures are the same for every run and number of threads")
{
    Layer ball = sphere("ball", 0.6, 3, {0.8f, 0.6f, 0.5f});
    Layer shell = sphere("shell", 0.8, 3, {0.5f, 0.6f, 0.7f});
    shell.opacity = 0.2f;
    shell.edge_opacity = 0.7f;
    RenderSettings settings;
    settings.width = settings.height = 120;
    settings.ground_height = -0.8;
    Camera camera = frame_points(shell.vertices, view_direction(View::three_quarter), 1.0);
    set_num_threads(1);
    const Image one = render({ball, shell}, camera, settings);
    set_num_threads(2);
    const Image two = render({ball, shell}, camera, settings);
    set_num_threads(0);
    CHECK(image_hash(one) == image_hash(two));
    // Light comes from above: the top of the ball is brighter than its lower half.
    CHECK(int(one.at(55, 35)[1]) > int(one.at(60, 90)[1]) + 20);
}

TEST_CASE("A framed body fills the picture and stays inside it")
{
    const Layer ball = sphere("ball", 0.5, 3, black);
    Points points = ball.vertices;
    points.col(1) *= 3.0;
    points.rowwise() += Eigen::RowVector3d(3, 2, -1);
    for (const double field_of_view : {0.0, 0.6})
        for (const View view : {View::front, View::back, View::left, View::right, View::three_quarter}) {
            const double aspect = 0.75;
            const Camera camera = frame_points(points, view_direction(view, 0.4), aspect, 0.05, field_of_view);
            double reach = 0;
            for (Eigen::Index i = 0; i < points.rows(); ++i) {
                const Eigen::Vector3d offset = points.row(i).transpose() - camera.position;
                const double depth = -offset.dot(camera.backward);
                CHECK(depth > 0);
                const double scale = 0.5 * camera.image_height * (field_of_view > 0 ? depth : 1.0);
                reach = std::max({reach, std::abs(offset.dot(camera.up)) / scale,
                                  std::abs(offset.dot(camera.right)) / (scale * aspect)});
            }
            CHECK(reach <= 1.0);
            CHECK(reach > 0.85);
        }
}

TEST_CASE("Views turn with the heading of the body")
{
    CHECK(view_direction(View::front).z() > 0.9);
    CHECK(view_direction(View::back).z() < -0.9);
    CHECK(view_direction(View::left).x() > 0.9);
    CHECK(view_direction(View::right).x() < -0.9);
    CHECK((view_direction(View::front, M_PI / 2) - view_direction(View::left)).norm() < 1e-12);
    CHECK_THROWS_AS(parse_view("above"), InputError);
    CHECK(parse_view("three-quarter") == View::three_quarter);
}

TEST_CASE("Malformed layers are refused")
{
    Layer layer = square("sheet", 1.0, 0.0, red);
    layer.triangles(0, 0) = 4;
    CHECK_THROWS_WITH(render({layer}, front_camera(), unlit(8)), Catch::Contains("sheet"));
    layer = square("sheet", 1.0, 0.0, red);
    layer.vertices(1, 1) = std::nan("");
    CHECK_THROWS_AS(render({layer}, front_camera(), unlit(8)), Error);
    layer = square("sheet", 1.0, 0.0, red);
    layer.vertex_colours.resize(3, 3);
    layer.vertex_colours.setZero();
    CHECK_THROWS_AS(render({layer}, front_camera(), unlit(8)), Error);
    CHECK_THROWS_AS(render({square("sheet", 1.0, 0.0, red)}, front_camera(), unlit(0)), Error);
}
