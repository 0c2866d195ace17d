// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/contact_sheet.h"

#include "ndg/core/error.h"
#include "ndg/scene/text.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <algorithm>

using namespace ndg;
using Catch::Matchers::Contains;

namespace {

PoseSet some_poses(const std::vector<double>& angles)
{
    PoseSet poses;
    poses.clip_names = {"walk", "a_clip_with_a_name_that_is_much_longer_than_a_thumbnail_is_wide"};
    poses.clip_frame_rates = {30, 30};
    for (std::size_t i = 0; i < angles.size(); ++i) {
        poses.poses.push_back(test::tube_pose(angles[i]));
        poses.clip_idx.push_back(static_cast<int>(i % 2));
        poses.frame_idx.push_back(static_cast<int>(10 * i));
    }
    return poses;
}

ContactSheetSettings small_settings(int columns)
{
    ContactSheetSettings settings;
    settings.cell_height = 160;
    settings.samples_per_axis = 1;
    settings.columns = columns;
    return settings;
}

/// Whether `part` stands somewhere in `image`, pixel by pixel, in one colour.
bool shows_text(const Image& image, const std::string& text, int scale)
{
    const Pixel background = {0, 0, 0}, ink = {255, 255, 255};
    Image wanted(text_width(text, scale), text_height(scale), background);
    draw_text(wanted, text, 0, 0, scale, ink);
    for (int y = 0; y + wanted.height <= image.height; ++y) {
        for (int x = 0; x + wanted.width <= image.width; ++x) {
            bool same = true;
            Pixel first = {0, 0, 0};
            bool found = false;
            for (int v = 0; same && v < wanted.height; ++v) {
                for (int u = 0; same && u < wanted.width; ++u) {
                    if (wanted.at(u, v) != ink) continue;
                    const Pixel& pixel = image.at(x + u, y + v);
                    if (!found) first = pixel;
                    found = true;
                    same = pixel == first && pixel[0] < 150;
                }
            }
            if (found && same) return true;
        }
    }
    return false;
}

}  // namespace

TEST_CASE("A contact sheet shows every pose with its number, clip and frame")
{
    const Template tube = test::tube_template();
    const BodyPoser poser(tube);
    const PoseSet poses = some_poses({0.0, 1.0, -1.0, 0.5, 0.2, 0.9});
    const Image sheet = contact_sheet(poser, tube.rest, poses, {0, 2, 4, 5}, small_settings(2));
    CHECK(sheet.height > 2 * 160);
    CHECK(sheet.height < 3 * 160);
    CHECK(shows_text(sheet, "4 of 6 poses", 3));
    for (const char* number : {"0", "2", "4", "5"}) {
        INFO(number);
        CHECK(shows_text(sheet, number, 2));
    }
    CHECK(shows_text(sheet, "walk 20", 1));
    CHECK(shows_text(sheet, "walk 40", 1));
    // Of a long name the end with the frame is kept.
    CHECK(shows_text(sheet, " 50", 1));
    CHECK_FALSE(shows_text(sheet, "walk 30", 1));
    const Image again = contact_sheet(poser, tube.rest, poses, {0, 2, 4, 5}, small_settings(2));
    CHECK(again.pixels == sheet.pixels);
}

TEST_CASE("Poses change thumbnails, the pose of the root does not")
{
    const Template tube = test::tube_template();
    const BodyPoser poser(tube);
    PoseSet poses = some_poses({0.0, 1.0, 0.0});
    const auto sheet_of = [&](int idx) {
        PoseSet one = poses;
        // The same caption for all.
        one.poses = {poses.poses[std::size_t(idx)]};
        one.clip_idx = {0};
        one.frame_idx = {0};
        return contact_sheet(poser, tube.rest, one, {0}, small_settings(1));
    };
    CHECK(sheet_of(0).pixels == sheet_of(2).pixels);
    CHECK(sheet_of(0).pixels != sheet_of(1).pixels);
    poses.poses[2].root_translation << 3, -1, 2;
    const Image moved = sheet_of(2), still = sheet_of(0);
    REQUIRE(moved.pixels.size() == still.pixels.size());
    // Rounding alone may differ.
    int differing = 0;
    for (std::size_t i = 0; i < moved.pixels.size(); ++i) {
        for (std::size_t c = 0; c < 3; ++c) differing += std::abs(moved.pixels[i][c] - still.pixels[i][c]) > 24 ? 1 : 0;
    }
    CHECK(differing < 30);
}

TEST_CASE("A contact sheet of nothing is refused")
{
    const Template tube = test::tube_template();
    const BodyPoser poser(tube);
    const PoseSet poses = some_poses({0.0});
    CHECK_THROWS_AS(contact_sheet(poser, tube.rest, poses, {}, small_settings(1)), InputError);
    CHECK_THROWS_WITH(contact_sheet(poser, tube.rest, poses, {1}, small_settings(1)),
                      Contains("Pose 1 lies outside the 1 poses"));
}
