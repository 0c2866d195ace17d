// SPDX-License-Identifier: Apache-2.0
#include "ndg/export/export_meshes.h"

#include "export/sequences.h"
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/io/mesh.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <cstring>
#include <filesystem>
#include <limits>

using namespace ndg;
using ndg::test::body_like;
using ndg::test::TemporaryFolder;

TEST_CASE("Every format of the table writes one frame under the name it is given, and nothing temporary stays")
{
    const TemporaryFolder folder;
    for (const ExportFormat& format : export_formats()) {
        INFO(format.extension);
        CHECK(&export_format("some/where" + format.extension) == &format);
        CHECK_FALSE(format.summary.empty());
        CHECK_THROWS_WITH(export_format("x.fbx"), Catch::Contains("'.fbx'") && Catch::Contains(format.extension));
        const std::string path = folder.file("X" + format.extension);
        export_meshes(path, format.contents == Contents::volume ? test::volume_like() : body_like());
        CHECK(std::filesystem::file_size(path) > 0);
        CHECK(exported_files(path, 1) == std::vector<std::string>{path});
    }
    for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
        CHECK(entry.path().extension() != ".tmp");
    CHECK(export_format("A.GLB").extension == ".glb");
    CHECK_THROWS_AS(export_meshes(folder.file("x.fbx"), body_like()), InputError);
}

TEST_CASE("A sequence becomes numbered files, each with its own frame")
{
    const TemporaryFolder folder;
    for (const ExportFormat& format : export_formats()) {
        if (format.frames == Frames::one_file || !is_mesh_name("x" + format.extension)) continue;
        INFO(format.extension);
        export_meshes(folder.file("out_{:04}" + format.extension), body_like(3));
        CHECK_FALSE(std::filesystem::exists(folder.file("out_0003" + format.extension)));
        for (int i = 0; i < 3; ++i) {
            const MeshFile mesh = read_mesh(folder.file("out_000" + std::to_string(i) + format.extension));
            CHECK(mesh.vertices.col(1).maxCoeff() == 1.0 + i);
            CHECK(mesh.triangles.rows() == 10);
        }
    }
    CHECK(exported_files("a_{}.obj", 2) == std::vector<std::string>{"a_0.obj", "a_1.obj"});
    CHECK(exported_files("a.pc2", 2) == std::vector<std::string>{"a.pc2"});
    CHECK_THROWS_WITH(exported_files("a.obj", 2),
                      "a.obj: 2 frames need the place of their number in the name, like {:04}");
    for (const std::string name : {"a_{.obj", "a_{}_{}.obj", "a_{x}.obj"})
        CHECK_THROWS_AS(exported_files(name, 2), InputError);
}

TEST_CASE("Meshes are merged with their groups, colours, scalars and credits")
{
    const TemporaryFolder folder;
    export_meshes(folder.file("x.obj"), body_like());
    const MeshFile obj = read_mesh(folder.file("x.obj"));
    CHECK(obj.vertices.rows() == 12);
    CHECK(obj.triangle_groups == std::vector<std::string>{"skin", "skin", "skin", "skin", "bones", "bones", "bones",
                                                          "bones", "muscle_wrap", "muscle_wrap"});
    CHECK(obj.triangles.row(8) == Eigen::RowVector3i(8, 10, 9));
    CHECK(read_file(folder.file("x.obj")).rfind("# CC0 1.0\n", 0) == 0);

    export_meshes(folder.file("x.ply"), body_like());
    const std::string ply = read_file(folder.file("x.ply"));
    CHECK_THAT(ply, Catch::Contains("comment CC0 1.0\n") &&
                        Catch::Contains("property uchar red\nproperty uchar green\nproperty uchar blue\n"
                                        "property float depth\nelement face 10\n"));
    const std::size_t body = ply.find("end_header\n") + 11, bytes = 3 * 4 + 3 + 4;
    const auto vertex = [&](std::size_t i) { return ply.substr(body + i * bytes, bytes); };
    CHECK(vertex(4).substr(12, 3) == "\xff\x99\x33");  // the colour of the bones
    CHECK(vertex(4).substr(15) == std::string(4, '\0'));
    CHECK(vertex(10).substr(12, 3) == "\x80\x80\x80");
    float depth = 0;
    std::memcpy(&depth, vertex(10).data() + 15, 4);
    CHECK(depth == 2.0f);
    CHECK(read_mesh(folder.file("x.ply")).vertices == obj.vertices);
}

TEST_CASE("A point cache holds the vertices of all frames in the order of the merged mesh")
{
    const TemporaryFolder folder;
    const std::string path = folder.file("x.pc2");
    export_meshes(path, body_like(5));
    const std::string bytes = read_file(path);
    REQUIRE(bytes.size() == 32 + 5 * 12 * 12);
    CHECK(bytes.substr(0, 12) == std::string("POINTCACHE2\0", 12));
    std::int32_t version = 0, num_points = 0, num_samples = 0;
    std::memcpy(&version, &bytes[12], 4);
    std::memcpy(&num_points, &bytes[16], 4);
    std::memcpy(&num_samples, &bytes[28], 4);
    CHECK(version == 1);
    CHECK(num_points == 12);
    CHECK(num_samples == 5);
    Eigen::Matrix<float, 12, 3, Eigen::RowMajor> last;
    std::memcpy(last.data(), &bytes[32 + 4 * 12 * 12], sizeof last);
    const std::vector<MeshFrame> frames = body_like().frame(4);
    CHECK(last.topRows(4).cast<double>() == frames[0].vertices);
    CHECK(last.bottomRows(4).cast<double>() == frames[2].vertices);
}

TEST_CASE("Frames are asked for in order, each once; a failure half-way leaves no half file")
{
    const TemporaryFolder folder;
    for (const std::string name : {"x.pc2", "x_{}.ply"}) {
        std::vector<int> asked;
        MeshSequence sequence = body_like(4);
        sequence.frame = [&, inner = sequence.frame](int frame_idx) {
            asked.push_back(frame_idx);
            std::vector<MeshFrame> frames = inner(frame_idx);
            if (asked.size() == 7) frames[1].vertices(2, 0) = std::numeric_limits<double>::quiet_NaN();
            return frames;
        };
        export_meshes(folder.file(name), sequence);
        CHECK(asked == std::vector<int>{0, 1, 2, 3});
        CHECK_THROWS_WITH(export_meshes(folder.file("bad_" + name), sequence),
                          Catch::Contains("bones has a vertex that is not finite"));
        std::filesystem::remove(folder.file("bad_x_0.ply"));
        std::filesystem::remove(folder.file("bad_x_1.ply"));
    }
    for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
        CHECK(entry.path().filename().string().rfind("x", 0) == 0);
}

TEST_CASE("Malformed sequences are refused")
{
    const TemporaryFolder folder;
    const auto refused = [&](const auto& spoil, const std::string& message) {
        MeshSequence sequence = body_like(2);
        spoil(sequence);
        CHECK_THROWS_WITH(export_meshes(folder.file("x.pc2"), sequence), Catch::Contains(message));
    };
    const auto spoiled = [](const auto& spoil) {
        return [spoil](MeshSequence& sequence) {
            sequence.frame = [spoil, inner = sequence.frame](int frame_idx) {
                std::vector<MeshFrame> frames = inner(frame_idx);
                spoil(frames, frame_idx);
                return frames;
            };
        };
    };
    using MeshFrames = std::vector<MeshFrame>;
    refused([](MeshSequence& s) { s.meshes.clear(); }, "would hold no mesh");
    refused([](MeshSequence& s) { s.num_frames = 0; }, "would hold no mesh");
    refused([](MeshSequence& s) { s.meshes[1].name = "skin"; }, "two meshes named \"skin\"");
    refused([](MeshSequence& s) { s.meshes[1].opacity = 1.5f; }, "opacity of bones is 1.5");
    refused([](MeshSequence& s) { s.meshes[1].triangles(0, 0) = -1; }, "bones has no or negative triangles");
    refused(spoiled([](MeshFrames& f, int) { f.pop_back(); }), "frame 0 has 2 meshes instead of 3");
    refused(spoiled([](MeshFrames& f, int) { f[0].vertices.conservativeResize(3, 3); }), "skin has a triangle index");
    refused(spoiled([](MeshFrames& f, int) { f[2].colours.conservativeResize(2, 3); }), "2 colours for 4 vertices");
    refused(spoiled([](MeshFrames& f, int) { f[2].scalars["depth"].resize(2); }), "depth of muscle_wrap is not one");
    refused(spoiled([](MeshFrames& f, int i) { f[0].vertices.conservativeResizeLike(Points::Zero(4 + i, 3)); }),
            "skin has 5 vertices in frame 1 instead of 4");
    CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("Rigs that do not fit are refused, and so are formats that hold none")
{
    const TemporaryFolder folder;
    const auto refused = [&](const auto& spoil, const std::string& message) {
        MeshSequence sequence = test::rig_like(2);
        spoil(*sequence.rig);
        for (const std::string name : {"x.glb", "x.usda"})
            CHECK_THROWS_WITH(export_meshes(folder.file(name), sequence), Catch::Contains(message));
    };
    refused([](Rig& rig) { rig.mesh_idx = 3; }, "the rig's mesh does not fit");
    refused([](Rig& rig) { rig.parents[1] = 1; }, "the parent of joint spine_1 is 1");
    refused([](Rig& rig) { rig.weight_joints(0, 0) = 2; }, "the rig's weights");
    refused([](Rig& rig) { rig.weights(3, 1) = 0.25; }, "weights do not sum to one");
    refused([](Rig& rig) { rig.rotations.pop_back(); }, "the rig has 1 frames instead of 2");
    refused([](Rig& rig) { rig.morphs[0].conservativeResize(3, 3); }, "a morph does not fit");
    CHECK_THROWS_WITH(export_meshes(folder.file("x.ply"), test::rig_like()), Catch::Contains("cannot hold a skeleton"));
    CHECK_THROWS_AS(export_meshes(folder.file("x_{}.glb"), test::rig_like(2)), InputError);
    CHECK(std::filesystem::is_empty(folder.path()));
}
