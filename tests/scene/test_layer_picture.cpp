// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/layer_picture.h"
#include "support/support.h"

#include <catch2/catch.hpp>

using namespace ndg;

TEST_CASE("A picture of a layer shows its tetrahedra inside the skin")
{
    // The tube, with what lies inside its bone wrap as the layer.
    const Template tube = test::tube_template(9, 8);
    LayerPicture layer;
    layer.skin = {tube.rest.skin_vertices, tube.skin_triangles};
    const int num_wrap = tube.num_wrap_vertices();
    layer.vertices.resize(num_wrap + tube.rest.interior_vertices.rows(), 3);
    layer.vertices << tube.rest.volume_vertices.topRows(num_wrap), tube.rest.interior_vertices;
    layer.tetrahedra = tube.tetrahedra;
    layer.joints.resize(2, 3);
    layer.joints << 0, 0.2, 0.05, 0, 0.8, 0.05;  // beside the layer, behind the frontal section's plane
    layer.parents = {-1, 0};
    layer.title = "tube";

    const auto share = [](const Image& image, bool (*is)(const Pixel&)) {
        double count = 0;
        for (const Pixel& pixel : image.pixels) count += is(pixel);
        return count / double(image.pixels.size());
    };
    const auto is_skin = [](const Pixel& p) { return p[0] == p[1] && p[1] == p[2] && p[0] > 215 && p[0] < 240; };
    const auto is_layer = [](const Pixel& p) { return p[0] > 220 && p[2] < 160; };
    const auto is_line = [](const Pixel& p) { return p[0] < 190 && p[2] < p[0]; };
    const Image image = layer_picture(layer, {0.5}, 400);
    CHECK(image.height > 400);
    // At y = 0.5 the bones have a cross section; the frontal plane goes through the joints, the sagittal one too.
    const double skin = share(image, is_skin), inside = share(image, is_layer), lines = share(image, is_line);
    CHECK(skin > 0.02);
    CHECK(inside > 0.005);
    CHECK(lines > 0.002);
    CHECK(inside < skin);

    LayerPicture thicker = layer;
    thicker.vertices.topRows(num_wrap) = tube.rest.volume_vertices.middleRows(num_wrap, num_wrap);
    CHECK(share(layer_picture(thicker, {0.5}, 400), is_layer) > 1.5 * inside);
    CHECK(layer_picture(layer, {0.3, 0.5, 0.7}, 400).width == image.width);
}
