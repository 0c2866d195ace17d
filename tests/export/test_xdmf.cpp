// SPDX-License-Identifier: Apache-2.0
#include "export/sequences.h"
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/export/export_meshes.h"
#include "ndg/io/h5.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <filesystem>
#include <limits>

using namespace ndg;
using ndg::test::TemporaryFolder;
using ndg::test::volume_like;

TEST_CASE("XDMF refers to what stands in files, by relative paths, and writes the rest beside it")
{
    const TemporaryFolder folder;
    const std::string path = folder.file("x.xdmf");
    export_meshes(path, volume_like(3));
    const std::string text = read_file(path);
    const std::string up = std::filesystem::relative("/a", folder.path()).string();
    CHECK_THAT(text, Catch::Contains("Value=\"CC0 1.0 &quot;&amp; more&quot;\""));
    CHECK_THAT(text, Catch::Contains(">" + up + "/template.h5:/volume/prisms<"));
    CHECK_THAT(text, Catch::Contains("<!--slice 2--><DataItem Format=\"XML\" Dimensions=\"3 3\">2 0 0 1 1 1 1 6 3<") &&
                         Catch::Contains("Dimensions=\"3 6 3\">" + up + "/samples.h5:/deformations/vertices<"));
    CHECK_THAT(text, Catch::Contains("x.xdmf.h5:/bone_interior/vertices") && !Catch::Contains(":/flesh/vertices"));

    const H5Reader fields(path + ".h5", "ndg-fields", 1);
    CHECK_FALSE(fields.has("/flesh/vertices"));
    CHECK(fields.read_slice("/bone_interior/vertices", 2)[1] == 2.0f);
    CHECK(fields.read_slice("/flesh/points/error", 2)[5] == 2.0f);
    CHECK(fields.read_slice("/bone_interior/cells/determinant", 1) == std::vector<float>{2.0f});
    CHECK(fields.read_doubles("/flesh/constant/layer") == std::vector<double>{1.0});
    CHECK_NOTHROW(check_h5(path + ".h5"));
}

TEST_CASE("Volumes that do not fit leave no file")
{
    const TemporaryFolder folder;
    const auto refused = [&](const auto& spoil, const std::string& message) {
        MeshSequence sequence = volume_like(2);
        sequence.volume->frame = [spoil, inner = sequence.volume->frame](int frame_idx) {
            std::vector<VolumeFrame> frames = inner(frame_idx);
            if (frame_idx == 1) spoil(frames);
            return frames;
        };
        CHECK_THROWS_WITH(export_meshes(folder.file("x.xdmf"), sequence), Catch::Contains(message));
        CHECK(std::filesystem::is_empty(folder.path()));
    };
    using VolumeFrames = std::vector<VolumeFrame>;
    refused([](VolumeFrames& f) { f.pop_back(); }, "frame 1 has 1 grids instead of 2");
    refused([](VolumeFrames& f) { f[0].point_fields["error"].conservativeResize(3); },
            "error of flesh has 3 values for 6");
    refused([](VolumeFrames& f) { f[1].vertices(0, 0) = std::numeric_limits<double>::infinity(); }, "not finite");
    refused([](VolumeFrames& f) { f[1].cell_fields.clear(); }, "determinant");
    MeshSequence none = test::body_like();
    CHECK_THROWS_WITH(export_meshes(folder.file("x.xdmf"), none), Catch::Contains("would hold no volume"));
}
