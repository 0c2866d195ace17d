// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/video.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/scene/video_file.h"
#include "scene/shapes.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <cstdlib>
#include <filesystem>

using namespace ndg;

namespace {

VideoSettings small_video()
{
    VideoSettings settings;
    settings.look = Look::skin;
    settings.width = 60;
    settings.height = 80;
    settings.samples_per_axis = 1;
    settings.occlusion_rays = 4;
    return settings;
}

/// The tube, leaning to one side so that no two views of it are alike, at rest or in `poses` places beside each other.
VideoMotion tube_motion(const Template& tube, int poses)
{
    VideoMotion motion;
    motion.body_template = &tube;
    motion.num_poses = poses;
    motion.pose_rate = 10;
    motion.moment = [&tube](int pose) {
        VideoMoment moment;
        moment.geometry = rest_geometry(tube, tube.rest);
        for (Points* points : {&moment.geometry.skin_vertices, &moment.geometry.volume_vertices}) {
            points->col(0) += 0.4 * points->col(1);
            points->col(0).array() += 0.1 * pose;
        }
        return moment;
    };
    motion.skin = [&tube](const VideoMoment& moment) { return skin_surface(tube, moment.geometry); };
    return motion;
}

int count_shown(const Image& image)
{
    return image.width * image.height - test::count_pixels(image, image.at(0, 0));
}

}  // namespace

TEST_CASE("A camera that goes once round a body ends where it began, and sees it from all sides")
{
    const Template tube = test::tube_template();
    VideoSettings settings = small_video();
    settings.turn_degrees = 360;
    settings.seconds = 0.32;
    const Video video(tube_motion(tube, 1), settings);
    REQUIRE(video.num_frames() == 8);
    CHECK(video.frame_rate() == 25);
    const Image first = video.frame(0);
    CHECK(video.frame(video.num_frames()).pixels == first.pixels);
    CHECK(video.frame(0).pixels == first.pixels);
    for (int i = 1; i < video.num_frames(); ++i) CHECK(video.frame(i).pixels != first.pixels);
    // Never cut off: nothing at the border but floor, and about as much of it from everywhere.
    for (int i = 0; i < video.num_frames(); ++i) {
        const Image image = video.frame(i);
        for (int y = 0; y < image.height / 2; ++y) {
            CHECK(image.at(0, y) == image.at(0, 0));
            CHECK(image.at(image.width - 1, y) == image.at(0, 0));
        }
        CHECK(count_shown(image) > count_shown(first) / 3);
    }
    // Six seconds round a body that stands still, and one picture where nothing moves.
    settings.seconds = 0;
    CHECK(Video(tube_motion(tube, 1), settings).num_frames() == 150);
    settings.turn_degrees = 0;
    CHECK(Video(tube_motion(tube, 1), settings).num_frames() == 1);
}

TEST_CASE("A video shows every pose at its time, over and over")
{
    const Template tube = test::tube_template();
    VideoSettings settings = small_video();
    const Video once(tube_motion(tube, 3), settings);
    REQUIRE(once.num_frames() == 3);
    CHECK(once.frame_rate() == 10);
    CHECK(once.frame(1).pixels != once.frame(0).pixels);
    CHECK(once.frame(2).pixels != once.frame(1).pixels);
    CHECK(once.frame(3).pixels == once.frame(0).pixels);
    settings.frame_rate = 20;
    settings.seconds = 0.5;
    const Video slow(tube_motion(tube, 3), settings);
    REQUIRE(slow.num_frames() == 10);
    for (int i = 0; i < 10; ++i) CHECK(slow.frame(i).pixels == once.frame(i / 2).pixels);
}

TEST_CASE("Layers stand side by side in one pose, at one scale")
{
    const Template tube = test::tube_template();
    VideoSettings settings = small_video();
    settings.look = Look::layers;
    settings.width = 240;
    const Image row = Video(tube_motion(tube, 1), settings).frame(0);
    settings.look = Look::skin;
    settings.width = 60;
    const Image skin = Video(tube_motion(tube, 1), settings).frame(0);
    for (int y = 0; y < 80; ++y)
        for (int x = 0; x < 60; ++x) CHECK(row.at(x, y) == skin.at(x, y));
    for (int column = 1; column < 4; ++column) {
        int shown = 0;
        for (int y = 0; y < 80; ++y)
            for (int x = 0; x < 60; ++x) shown += row.at(60 * column + x, y) != row.at(0, 0);
        CHECK(shown > 100);
    }
}

TEST_CASE("Occlusion and supersampling change what they should")
{
    // A ball close over a floor that it shades.
    SceneSurface floor = test::square("floor", 2.0, 0.0, {1, 1, 1});
    const SceneSurface rest = floor;
    floor.vertices.col(2) = -rest.vertices.col(1);
    floor.vertices.col(1).setConstant(-0.55);
    SceneSurface grid = floor;  // occlusion is of vertices: many of them
    const int side = 80;
    grid.vertices.resize((side + 1) * (side + 1), 3);
    grid.triangles.resize(2 * side * side, 3);
    for (int i = 0; i <= side; ++i)
        for (int k = 0; k <= side; ++k)
            grid.vertices.row(i * (side + 1) + k) << -2.0 + 4.0 * k / side, -0.55, 2.0 - 4.0 * i / side;
    for (int i = 0; i < side; ++i)
        for (int k = 0; k < side; ++k) {
            const int a = i * (side + 1) + k, b = a + side + 1;
            grid.triangles.row(2 * (i * side + k)) << a, a + 1, b + 1;
            grid.triangles.row(2 * (i * side + k) + 1) << a, b + 1, b;
        }
    const std::vector<SceneSurface> surfaces = {test::sphere("ball", 0.5, 4, {1, 0, 0}), grid};
    RenderSettings settings;
    settings.width = settings.height = 100;
    const Camera camera = frame_points(surfaces[0].vertices, Eigen::Vector3d(0, 0.7, 1), 1.0, 0.5);
    const Image shaded = render(surfaces, camera, settings);
    settings.occlusion_rays = 0;
    const Image open = render(surfaces, camera, settings);
    // Beside the foot of the ball the floor is darker; far away nothing changes.
    int darker = 0, lighter = 0;
    for (std::size_t i = 0; i < open.pixels.size(); ++i) {
        darker += shaded.pixels[i][1] + 12 < open.pixels[i][1];
        lighter += shaded.pixels[i][1] > open.pixels[i][1] + 1;
    }
    CHECK(darker > 200);
    CHECK(lighter == 0);
    CHECK(int(shaded.at(2, 2)[1]) >= int(open.at(2, 2)[1]) - 2);

    // One ray a pixel knows two tones of a flat disc, four know those between.
    settings.lit = false;
    settings.background = {1, 1, 1};
    const std::vector<SceneSurface> disc = {test::sphere("ball", 0.5, 4, {0, 0, 0})};
    const auto tones = [&](int samples) {
        settings.samples_per_axis = samples;
        const Image image = render(disc, camera, settings);
        return image.width * image.height - test::count_pixels(image, {0, 0, 0}) -
               test::count_pixels(image, {255, 255, 255});
    };
    CHECK(tones(1) == 0);
    CHECK(tones(2) > 50);
    CHECK(tones(2) < 400);
}

TEST_CASE("Videos become numbered pictures and animated files")
{
    const test::TemporaryFolder folder;
    const Template tube = test::tube_template();
    VideoSettings settings = small_video();
    const Video video(tube_motion(tube, 3), settings);
    write_video(folder.path() + "/frame_{:02}.png", video, 80);
    for (const char* name : {"frame_00.png", "frame_01.png", "frame_02.png"})
        CHECK(read_file(folder.path() + "/" + name).substr(1, 3) == "PNG");
    CHECK_FALSE(std::filesystem::exists(folder.path() + "/frame_03.png"));
    CHECK_THROWS_WITH(write_video(folder.path() + "/one.png", video, 80), Catch::Contains("{:04}"));
    CHECK_THROWS_WITH(write_video(folder.path() + "/video.avi", video, 80), Catch::Contains(".webp"));

    write_video(folder.path() + "/video.webp", video, 80);
    const std::string webp = read_file(folder.path() + "/video.webp");
    CHECK(webp.substr(0, 4) == "RIFF");
    CHECK(webp.substr(8, 8) == "WEBPVP8X");
    int frames = 0;
    for (std::size_t at = webp.find("ANMF"); at != std::string::npos; at = webp.find("ANMF", at + 4)) ++frames;
    CHECK(frames == 3);
}

TEST_CASE("A video that needs ffmpeg says so where there is none, and leaves nothing")
{
    const test::TemporaryFolder folder;
    const std::string path = std::getenv("PATH");
    ::setenv("PATH", "/nowhere", 1);
    CHECK_THROWS_WITH(video_writer(folder.path() + "/video.mp4", 3, 25, 80), Catch::Contains("ffmpeg"));
    ::setenv("PATH", path.c_str(), 1);
    CHECK(std::filesystem::is_empty(folder.path()));
    if (std::system("command -v ffmpeg > /dev/null") != 0) {
        WARN("skipped: ffmpeg is not installed");
        return;
    }
    std::unique_ptr<VideoWriter> writer = video_writer(folder.path() + "/video.mp4", 3, 25, 80);
    for (int i = 0; i < 3; ++i) writer->add(Image(61, 40, {std::uint8_t(80 * i), 0, 0}));  // odd widths too
    writer->finish();
    CHECK(read_file(folder.path() + "/video.mp4").substr(4, 4) == "ftyp");
    // One that ends half-way leaves nothing.
    writer = video_writer(folder.path() + "/half.mp4", 3, 25, 80);
    writer->add(Image(60, 40));
    writer.reset();
    CHECK_FALSE(std::filesystem::exists(folder.path() + "/half.mp4"));
    int files = 0;
    for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder.path())) ++files;
    CHECK(files == 1);
}
