// SPDX-License-Identifier: Apache-2.0
#include "ndg/page/page.h"

#include "ndg/body/anatomy.h"
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/geometry/rotation.h"
#include "ndg/page/carried_anatomy.h"
#include "ndg/page/page_blocks.h"
#include "ndg/page/viewer_bundle.h"
#include "support/support.h"

#include <zlib.h>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <cstring>
#include <filesystem>

using namespace ndg;
using ndg::test::TemporaryFolder;
using ndg::test::tube_pose;
using ndg::test::tube_template;

namespace {

std::string inflated(const std::string& packed, std::size_t size)
{
    std::string bytes(size, '\0');
    uLongf length = uLongf(size);
    REQUIRE(uncompress(reinterpret_cast<Bytef*>(bytes.data()), &length, reinterpret_cast<const Bytef*>(packed.data()),
                       uLong(packed.size())) == Z_OK);
    REQUIRE(length == size);
    return bytes;
}

std::string from_base64(const std::string& text)
{
    static const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    std::uint32_t bits = 0;
    int count = 0;
    for (const char c : text) {
        if (c == '=') break;
        bits = bits << 6 | std::uint32_t(digits.find(c));
        count += 6;
        if (count >= 8) bytes += char(bits >> (count -= 8) & 255);
    }
    return bytes;
}

/// The numbers of a packed table, by the description in page_blocks.h.
std::vector<int> unpacked(const std::string& packed, std::size_t count, std::size_t row, std::size_t stride)
{
    const std::string planes = inflated(packed, 2 * count);
    std::vector<int> values(count);
    for (std::size_t i = 0; i < count; ++i) {
        const int before = i >= row ? values[i - row] : i >= stride ? values[i - stride] : 0;
        values[i] = (before + std::uint8_t(planes[i]) + 256 * std::uint8_t(planes[count + i])) & 0xffff;
    }
    return values;
}

/// A block of a page with the number after `key:` in it.
struct Block {
    std::string text;
    std::size_t number(const std::string& key) const
    {
        return std::stoul(text.substr(text.find(key + ":") + key.size() + 1));
    }
    std::string packed() const
    {
        const std::size_t begin = text.find("data:\"") + 6;
        return from_base64(text.substr(begin, text.find('"', begin) - begin));
    }
};

/// The `which`-th block of a name.
Block find_block(const std::string& page, const std::string& name, int which = 0)
{
    std::size_t at = 0;
    for (int k = 0; k <= which; ++k) {
        at = page.find("NdgViewer.add({name:\"" + name + "\"", at + 1);
        REQUIRE(at != std::string::npos);
    }
    return {page.substr(at, page.find("</script>", at) - at)};
}

nlohmann::json head_of(const std::string& page)
{
    const std::string opening = "<script>NdgViewer.open(";
    const std::size_t begin = page.find(opening) + opening.size();
    return nlohmann::json::parse(page.substr(begin, page.find(")</script>", begin) - begin));
}

struct Scene {
    Template tube = tube_template();
    BodyPoser poser{tube, ndg::test::bending};
    PageMotion motion;

    Scene()
    {
        motion.title = "A <bent> tube";
        motion.body = &tube.rest;
        motion.credits = "CC0 & more";
        motion.frame_rate = 12.5;
        for (const double angle : {0.0, 0.4, 0.9}) motion.poses.push_back(tube_pose(angle));
        motion.methods = {{"LBS", [this](int f) { return skinned(f); }},
                          {"Higher", [this](int f) {
                               Points volume = skinned(f);
                               volume.bottomRows(tube.num_wrap_vertices()).col(1).array() += 0.01 * f;
                               return volume;
                           }}};
    }
    Points skinned(int f) const { return poser.pose(tube.rest, motion.poses[f]).skinned_volume(); }
};

}  // namespace

TEST_CASE("Tables come back from their packed form, whatever differs from whatever")
{
    std::vector<std::uint16_t> values;
    std::uint32_t state = 7;
    for (int i = 0; i < 600; ++i) values.push_back(std::uint16_t((state = state * 1664525u + 1013904223u) >> 16));
    for (const std::size_t row : {600u, 60u, 12u}) {
        INFO(row);
        const std::vector<int> back = unpacked(pack_values(values, row, 3), values.size(), row, 3);
        CHECK(std::equal(values.begin(), values.end(), back.begin(), back.end()));
    }
    const std::vector<float> floats = {1.0f, -0.25f, 3e-7f};
    const std::string planes = inflated(pack_floats(floats), 12);
    for (std::size_t i = 0; i < 3; ++i) {
        char bytes[4];
        for (std::size_t k = 0; k < 4; ++k) bytes[k] = planes[3 * k + i];
        float value = 0;
        std::memcpy(&value, bytes, 4);
        CHECK(value == floats[i]);
    }
    // RFC 4648, section 10.
    CHECK(base64("") == "");
    CHECK(base64("f") == "Zg==");
    CHECK(base64("fo") == "Zm8=");
    CHECK(base64("foo") == "Zm9v");
    CHECK(base64("foobar") == "Zm9vYmFy");
    CHECK(from_base64(base64(std::string("\xff\x00\x80", 3))) == std::string("\xff\x00\x80", 3));
}

TEST_CASE("Anatomy of a bending body is carried by the volume, of a turning one bones ride on their motion")
{
    Template tube = tube_template();
    const BodyPoser poser(tube, ndg::test::bending);
    const Points rest = anatomy_at_rest(tube, tube.rest);
    const auto carried_by = [&](const std::vector<Pose>& poses) {
        std::vector<PosedBody> frames;
        std::vector<Points> volumes, anatomies;
        for (const Pose& pose : poses) {
            frames.push_back(poser.pose(tube.rest, pose));
            volumes.push_back(frames.back().skinned_volume());
            anatomies.push_back(frames.back().anatomy(rest, volumes.back()));
        }
        const CarriedAnatomy carried = find_carriers(frames, volumes, anatomies, 1e-5);
        for (std::size_t f = 0; f < frames.size(); ++f) {
            const Points& anatomy = anatomies[f];
            const Points points = carried_points(carried, tube.embedding, volumes[f], frames[f].bone_interior(),
                                                 rigid_motions(carried, tube, anatomy), anatomy);
            CHECK((points - anatomy).rowwise().norm().maxCoeff() < 1e-5);
        }
        return carried;
    };
    const int bone_end = tube.anatomy_parts[0].vertex_end;
    const CarriedAnatomy bent = carried_by({tube_pose(0.0), tube_pose(0.8)});
    CHECK(bent.stored.empty());
    CHECK(*std::max_element(bent.shares.begin(), bent.shares.begin() + bone_end) < 1.0);

    Pose turned = tube_pose(0.0);
    turned.parent_from_joint[0] = about_z(0.7);
    turned.root_translation = {0.1, 0.2, 0.3};
    const CarriedAnatomy rigid = carried_by({tube_pose(0.0), turned});
    for (int v = 0; v < bone_end; ++v) CHECK(rigid.shares[v] == 1.0);
    for (std::size_t v = std::size_t(bone_end); v < rigid.shares.size(); ++v) CHECK(rigid.shares[v] == 0.0);
    const PosedBody posed = poser.pose(tube.rest, turned);
    const Points anatomy = posed.anatomy(rest, posed.skinned_volume());
    CHECK(rigid_motions(rigid, tube, anatomy)[0].isApprox(posed.world_from_rest()[0], 1e-9));

    // What lies beyond the cuts has no element: with two joints it bends by itself and is stored.
    const int free_vertex = tube.anatomy_parts[1].vertex_begin;
    tube.embedding.elements[free_vertex] = -1;
    tube.embedding.weights.row(free_vertex).setZero();
    CHECK(carried_by({tube_pose(0.0), tube_pose(0.8)}).stored == std::vector<int>{free_vertex});
}

TEST_CASE("A page holds the frames of every method within what it says")
{
    const TemporaryFolder folder;
    const Scene scene;
    const std::string path = folder.file("page.html");
    const PageFigures figures = write_page(path, scene.poser, scene.motion);
    CHECK(figures.largest_error < 1e-4);
    CHECK(figures.num_stored == 0);
    CHECK(figures.num_anatomy == scene.tube.anatomy_vertices.rows());

    const std::string page = read_file(path);
    CHECK(page.find(viewer_bundle()) != std::string::npos);
    CHECK(page.find("<title>A &lt;bent&gt; tube</title>") != std::string::npos);
    CHECK(page.find("CC0 &amp; more") != std::string::npos);
    CHECK(page.substr(page.size() - 50).find("NdgViewer.end()") != std::string::npos);
    const nlohmann::json head = head_of(page);
    CHECK(head["title"] == "A <bent> tube");
    CHECK(head["frame_rate"] == 12.5);
    CHECK(head["num_frames"] == 3);
    CHECK(head["methods"] == nlohmann::json({"LBS", "Higher"}));
    CHECK(head["bones"][0]["name"] == "shaft");
    CHECK(head["muscles"][0]["name"] == "muscle");

    // Frames 1 and 2 stand in the second block of a method; the skin wrap is its last part.
    const int num_wrap = scene.tube.num_wrap_vertices();
    const double span = head["span"];
    for (int m = 0; m < 2; ++m) {
        const Block block = find_block(page, "method_" + std::to_string(m), 1);
        CHECK(block.number("frame") == 1);
        const std::size_t row = block.number("row"), count = block.number("count");
        REQUIRE(row == std::size_t(6 * num_wrap));
        REQUIRE(count == 2 * row);
        const std::vector<int> values = unpacked(block.packed(), count, row, block.number("stride"));
        for (int f = 1; f < 3; ++f) {
            const Points truth = scene.motion.methods[m].volume(f).bottomRows(2 * num_wrap);
            double largest = 0.0;
            for (Eigen::Index i = 0; i < truth.size(); ++i) {
                const double origin = head["origins"][f][i % 3];
                const double value = (2.0 * values[(f - 1) * row + i] / 65535.0 - 1.0) * span + origin;
                largest = std::max(largest, std::abs(value - truth.data()[i]));
            }
            CHECK(largest <= span / 65535.0 * 1.0001);
        }
    }
    const Block triangles = find_block(page, "wrap_triangles");
    const std::vector<int> indices =
        unpacked(triangles.packed(), triangles.number("count"), triangles.number("count"), 3);
    CHECK(std::equal(indices.begin(), indices.end(), scene.tube.wrap_triangles.data(),
                     scene.tube.wrap_triangles.data() + scene.tube.wrap_triangles.size()));
}

TEST_CASE("What no page can show is refused, and leaves nothing behind")
{
    const TemporaryFolder folder;
    Scene scene;
    PageMotion motion = scene.motion;
    motion.methods[1].volume = [&](int f) { return Points(scene.skinned(f).topRows(5)); };
    CHECK_THROWS_WITH(write_page(folder.file("a.html"), scene.poser, motion),
                      Catch::Contains("Higher gives 5 volume vertices"));
    motion = scene.motion;
    motion.poses.clear();
    CHECK_THROWS_AS(write_page(folder.file("a.html"), scene.poser, motion), Error);
    CHECK_THROWS_AS(write_page(folder.file("none/a.html"), scene.poser, scene.motion), Error);
    CHECK(std::filesystem::is_empty(folder.path()));
}
