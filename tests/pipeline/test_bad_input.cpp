// SPDX-License-Identifier: Apache-2.0
// Every kind of bad input ends a tool with exit code 2, one sentence that names it, and nothing half-written.
#include "ndg/body/template.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

using namespace ndg;
using namespace ndg::test;
using Catch::Matchers::Contains;

namespace {

void write_text(const std::string& path, const std::string& text)
{
    std::ofstream(path, std::ios::binary) << text;
}

std::string read_text(const std::string& path)
{
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// Runs a tool that must fail with exit code 2 and one line of text.
std::string refused(const std::string& command)
{
    const CommandResult result = run_command(command);
    INFO(command << "\n" << result.output);
    CHECK(result.exit_code == 2);
    CHECK(std::count(result.output.begin(), result.output.end(), '\n') == 1);
    return result.output;
}

std::size_t files_in(const std::string& folder)
{
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

const char* const bvh_head =
    "HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation\n"
    "JOINT Spine\n{\nOFFSET 0 10 0\nCHANNELS 3 Zrotation Yrotation Xrotation\nEnd Site\n{\nOFFSET 0 10 0\n}\n}\n}\n";

}  // namespace

TEST_CASE("a truncated HDF5 file is refused by name", "[pipeline]")
{
    const TemporaryFolder folder;
    write_template(folder.file("template.h5"), tube_template(), {});
    const std::string whole = read_text(folder.file("template.h5"));
    write_text(folder.file("cut.h5"), whole.substr(0, whole.size() / 2));
    const std::string text =
        refused(tool_path("fit-shape-space") + " --template " + folder.file("cut.h5") + " --bodies " +
                folder.file("cut.h5") + " --splits " + folder.file("cut.h5") + " --output " + folder.file("out.h5"));
    CHECK_THAT(text, Contains("cut.h5"));
    CHECK(files_in(folder.path()) == 2);
}

TEST_CASE("a misspelt configuration key is refused with the nearest known one", "[pipeline]")
{
    const TemporaryFolder folder;
    write_text(folder.file("config.json"), R"({"make-template": {"keep_ratoi": 0.03}})");
    std::filesystem::create_directory(folder.file("makehuman"));
    const std::string text = refused(tool_path("make-template") + " --config " + folder.file("config.json") +
                                     " --makehuman " + folder.file("makehuman") + " --output " + folder.file("out.h5"));
    CHECK_THAT(text, Contains("keep_ratoi") && Contains("keep_ratio"));
    CHECK(!std::filesystem::exists(folder.file("out.h5")));
}

TEST_CASE("an OBJ file with a bad index is refused with line and value", "[pipeline]")
{
    const TemporaryFolder folder;
    write_text(folder.file("bad.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
    const std::string text = refused(tool_path("ndg-info") + " " + folder.file("bad.obj"));
    CHECK_THAT(text, Contains("bad.obj") && Contains("9") && Contains("4"));
}

TEST_CASE("a BVH frame with too few channel values is refused with frame and counts", "[pipeline]")
{
    const TemporaryFolder folder;
    write_template(folder.file("template.h5"), tube_template(), {});
    write_text(folder.file("short.bvh"),
               std::string(bvh_head) + "MOTION\nFrames: 2\nFrame Time: 0.01\n0 0 0 0 0 0 0 0 0\n0 0 0 0 0 0 0\n");
    const std::string text = refused(tool_path("import-motion") + " --template " + folder.file("template.h5") +
                                     " --joint-maps " + std::string(NDG_TEST_SOURCE) + "/configs/joint-maps --motion " +
                                     folder.file("short.bvh") + " --output " + folder.file("poses.h5"));
    CHECK_THAT(text, Contains("short.bvh") && Contains("7") && Contains("9"));
    CHECK(!std::filesystem::exists(folder.file("poses.h5")));
}

TEST_CASE("missing files and unknown options are refused", "[pipeline]")
{
    const TemporaryFolder folder;
    CHECK_THAT(refused(tool_path("ndg-info") + " " + folder.file("nothing.h5")), Contains("nothing.h5"));
    CHECK_THAT(refused(tool_path("make-splits") + " --no-such-option 3"), Contains("no-such-option"));
    CHECK_THAT(refused(tool_path("make-splits")), Contains("make-splits"));
}

TEST_CASE("exports that cannot be are refused before anything is written", "[pipeline]")
{
    const TemporaryFolder folder;
    REQUIRE(run_command(tool_path("small-dataset") + " " + folder.path() + " 5 6").exit_code == 0);
    const std::size_t inputs = files_in(folder.path());
    const auto refuses = [&](const std::string& arguments, const std::string& word) {
        CHECK_THAT(refused(tool_path("export-scene") + " --bone-wrap lbs --template " + folder.file("template.h5") +
                           " --bodies " + folder.file("bodies.h5") + " --poses " + folder.file("poses.h5") +
                           " --mesh " + folder.file(arguments)),
                   Contains(word));
        CHECK(files_in(folder.path()) == inputs);
    };
    refuses("x.fbx", "known are .glb");
    refuses("template.h5/x.usda", "template.h5");
    refuses("x.ply --pose 0 --frames 2", "{:04}");
    refuses("x.glb --sample 0", "needs exactly one --deformations file");
    refuses("x.glb --pose 1000", "Pose 1000");
    refuses("x.ply --rig skinning --pose 0", "holds no skeleton");
    refuses("x.glb --rig skinning --surface bones --pose 0", "--surface must be skin");
    refuses("x.glb --rig morphs --pose 0", "needs --sample");
    refuses("x.glb --rig skinning --influences 5 --pose 0", "4 or 8");
    refuses("x.xdmf --pose 0 --reference " + folder.file("poses.h5"), "--reference needs --sample");
}
