// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/image.h"

#include "ndg/core/error.h"
#include "ndg/scene/text.h"
#include "scene/shapes.h"
#include "support/support.h"

#include <png.h>
#include <catch2/catch.hpp>

#include <cstring>
#include <filesystem>

using namespace ndg;
using ndg::test::count_pixels;

namespace {

Image read_png(const std::string& path)
{
    png_image reader;
    std::memset(&reader, 0, sizeof reader);
    reader.version = PNG_IMAGE_VERSION;
    REQUIRE(png_image_begin_read_from_file(&reader, path.c_str()) != 0);
    reader.format = PNG_FORMAT_RGB;
    Image image(int(reader.width), int(reader.height));
    REQUIRE(png_image_finish_read(&reader, nullptr, image.pixels.data(), 0, nullptr) != 0);
    return image;
}

}  // namespace

TEST_CASE("A written PNG is read back by libpng as it was")
{
    const test::TemporaryFolder folder;
    Image image(37, 23);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            image.at(x, y) = {std::uint8_t(7 * x), std::uint8_t(11 * y), std::uint8_t(x * y)};
    write_png(folder.file("a.png"), image);
    const Image read = read_png(folder.file("a.png"));
    CHECK(read.width == 37);
    CHECK(read.height == 23);
    CHECK(read.pixels == image.pixels);
    // Nothing temporary stays, and writing again replaces.
    write_png(folder.file("a.png"), Image(2, 2, {1, 2, 3}));
    CHECK(read_png(folder.file("a.png")).pixels == std::vector<Pixel>(4, Pixel{1, 2, 3}));
    std::size_t files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path())) files += entry.exists() ? 1 : 0;
    CHECK(files == 1);
    CHECK_THROWS_AS(write_png(folder.file("none/a.png"), image), Error);
    CHECK_THROWS_AS(write_png(folder.file("b.png"), Image()), Error);
}

TEST_CASE("The sRGB transfer function and its inverse")
{
    CHECK(srgb_from_linear(0.0f) == 0.0f);
    CHECK(srgb_from_linear(1.0f) == Approx(1.0f));
    CHECK(srgb_from_linear(0.5f) == Approx(0.7353569f));
    CHECK(linear_from_srgb(0.5f) == Approx(0.2140411f));
    for (int i = 0; i <= 255; ++i)
        CHECK(int(pixel_from_linear(linear_from_srgb(Eigen::Vector3f::Constant(float(i) / 255.0f)))[0]) == i);
}

TEST_CASE("Letters are drawn from their bitmap at an integer scale and cut off at the edge")
{
    Image image(20, 20);
    draw_text(image, "I", 2, 3, 1, {0, 0, 0});
    CHECK(count_pixels(image, {0, 0, 0}) == 3 + 5 + 3);
    CHECK(image.at(4, 6) == Pixel{0, 0, 0});
    CHECK(image.at(2, 3) == Pixel{255, 255, 255});
    Image large(40, 40);
    draw_text(large, "I", 0, 0, 3, {0, 0, 0});
    CHECK(count_pixels(large, {0, 0, 0}) == 9 * 11);
    Image edge(3, 3);
    draw_text(edge, "MMMM", -2, -2, 2, {0, 0, 0});
    CHECK(text_width("ab", 2) == 22);
    CHECK(text_width("", 2) == 0);
    // Every printable character but the space has a bitmap.
    for (int code = 33; code < 127; ++code) {
        Image glyph(6, 10);
        draw_text(glyph, std::string(1, char(code)), 0, 0, 1, {0, 0, 0});
        INFO("character " << char(code));
        CHECK(count_pixels(glyph, {0, 0, 0}) > 1);
    }
}

TEST_CASE("A sheet holds every image, row by row, and its labels")
{
    const std::vector<Image> images = {Image(30, 20, {255, 0, 0}), Image(30, 20, {0, 255, 0}),
                                       Image(30, 20, {0, 0, 255})};
    const Image sheet = tile_images(images, 2, {"", {"one", "two"}, {"a", "b"}, ""}, {250, 250, 250});
    int red = 0, green = 0, blue = 0;
    Eigen::Vector2d red_at(0, 0), green_at(0, 0), blue_at(0, 0);
    for (int y = 0; y < sheet.height; ++y)
        for (int x = 0; x < sheet.width; ++x) {
            const Pixel& pixel = sheet.at(x, y);
            if (pixel == Pixel{255, 0, 0}) ++red, red_at += Eigen::Vector2d(x, y);
            if (pixel == Pixel{0, 255, 0}) ++green, green_at += Eigen::Vector2d(x, y);
            if (pixel == Pixel{0, 0, 255}) ++blue, blue_at += Eigen::Vector2d(x, y);
        }
    CHECK(red == 600);
    CHECK(green == 600);
    CHECK(blue == 600);
    CHECK(red_at.y() == green_at.y());
    CHECK(red_at.x() < green_at.x());
    CHECK(red_at.x() == blue_at.x());
    CHECK(red_at.y() < blue_at.y());
    CHECK_THROWS_AS(tile_images(images, 2, {"", {"one"}, {}, ""}), Error);
    CHECK_THROWS_AS(tile_images({}, 2, {}), Error);
}
