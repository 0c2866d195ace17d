// SPDX-License-Identifier: Apache-2.0
// The executable ndg-info as a user runs it.
#include "ndg/body/pose_set.h"
#include "ndg/core/file.h"
#include "ndg/core/hash.h"
#include "ndg/io/h5.h"
#include "ndg/io/mesh.h"
#include "support/h5_damage.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>

using namespace ndg;
using namespace ndg::test;

namespace {

CommandResult info(const std::string& arguments)
{
    return run_command(tool_path("ndg-info") + " " + arguments);
}

void write_example(const std::string& path)
{
    Provenance provenance;
    provenance.tool = "make-template";
    provenance.licences = "CC0: base mesh\nCC-BY: anatomy";
    H5Writer writer(path, "test-file", 1, provenance);
    writer.write("/skin/vertices", RowMatrix::Random(5000, 3), "positions, m");
    writer.commit();
}

}  // namespace

TEST_CASE("ndg-info shows attributes, datasets and licences")
{
    REQUIRE(std::filesystem::exists(tool_path("ndg-info")));
    const TemporaryFolder folder;
    write_example(folder.file("x.h5"));
    const CommandResult result = info(folder.file("x.h5") + " --check");
    INFO(result.output);
    CHECK(result.exit_code == 0);
    for (const char* part : {"test-file", "CC-BY: anatomy", "/skin/vertices", "float32", "5000 x 3", "positions, m",
                             "make-template 0.", "complete and finite"}) {
        CHECK_THAT(result.output, Catch::Contains(part));
    }
}

TEST_CASE("ndg-info on broken files: exit code 2 and one line")
{
    REQUIRE(std::filesystem::exists(tool_path("ndg-info")));
    const TemporaryFolder folder;
    write_example(folder.file("x.h5"));
    std::string bytes = read_file(folder.file("x.h5"));
    write_file(folder.file("cut.h5"), bytes.substr(0, bytes.size() / 2));
    bytes[bytes.size() / 2] ^= 1;
    write_file(folder.file("flipped.h5"), bytes);
    const auto check_refused = [&](const std::string& arguments, const std::string& message) {
        const CommandResult result = info(arguments);
        INFO(result.output);
        CHECK(result.exit_code == 2);
        CHECK(std::count(result.output.begin(), result.output.end(), '\n') == 1);
        CHECK_THAT(result.output, Catch::StartsWith("ndg-info: error: ") && Catch::Contains(message));
    };
    check_refused(folder.file("cut.h5"), "cut.h5: cannot open, truncated or damaged");
    check_refused(folder.file("flipped.h5") + " --check", "flipped.h5: cannot read dataset /skin/vertices");
    check_refused(folder.file("missing.h5"), "missing.h5 does not exist");
    check_refused("", "FILE is missing");
}

TEST_CASE("ndg-info on a mesh shows counts and box")
{
    REQUIRE(std::filesystem::exists(tool_path("ndg-info")));
    const TemporaryFolder folder;
    const Points vertices = (Points(3, 3) << 0, 0, 0, 1.5, 0, 0, 0, 2, -1).finished();
    write_mesh(folder.file("x.ply"), vertices, (Triangles(1, 3) << 0, 1, 2).finished());
    const CommandResult result = info(folder.file("x.ply"));
    CHECK(result.exit_code == 0);
    CHECK_THAT(result.output, Catch::Contains("vertices     3") && Catch::Contains("triangles    1") &&
                                  Catch::Contains("0 0 -1 to 1.5 2 0"));
}

TEST_CASE("ndg-info tells whether the files that a file was made of have changed")
{
    const TemporaryFolder folder;
    write_file(folder.file("input.txt"), "as it was");
    Provenance provenance;
    provenance.tool = "make-template";
    provenance.inputs = {{folder.file("input.txt"), sha256("as it was"), "", false},
                         {"elsewhere/lost.h5", sha256("lost"), "", false}};
    H5Writer writer(folder.file("x.h5"), "test-file", 1, provenance);
    writer.write("/numbers", std::vector<double>{1, 2}, "two numbers");
    writer.commit();
    const CommandResult same = info(folder.file("x.h5") + " --check");
    CHECK(same.exit_code == 0);
    CHECK_THAT(same.output,
               Catch::Contains("the same now") && Catch::Contains("lost.h5") && Catch::Contains("not found"));
    write_file(folder.file("input.txt"), "as it is");
    const CommandResult changed = info(folder.file("x.h5") + " --check");
    CHECK(changed.exit_code == 3);
    CHECK_THAT(changed.output,
               Catch::Contains("ANOTHER now") && Catch::Contains("its input " + folder.file("input.txt")));
    CHECK(info(folder.file("x.h5")).exit_code == 0);  // hashes of large inputs are computed when asked for alone
}

TEST_CASE("ndg-info explains motions, pictures, caches and JSON")
{
    const TemporaryFolder folder;
    write_file(folder.file("odd.bvh"),
               "HIERARCHY\nROOT Odd\n{\nOFFSET 0 0 0\nCHANNELS 6 Xposition Yposition Zposition "
               "Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET 0 1 0\n}\n}\nMOTION\n"
               "Frames: 2\nFrame Time: 0.01\n0 0 0 0 0 0\n3 0 4 0 0 0\n");
    const CommandResult motion = info(folder.file("odd.bvh"));
    CHECK(motion.exit_code == 0);
    CHECK_THAT(motion.output, Catch::Contains("2 at 100 Hz, 0.02 s") && Catch::Contains("1: Odd") &&
                                  Catch::Contains("3 x 0 x 4") && Catch::Contains("none fits"));
    const std::string configs = std::string(NDG_TEST_SOURCE) + "/configs/";
    CHECK_THAT(info(configs + "motions/squat.json").output,
               Catch::Contains("keyframes") && Catch::Contains("Apache-2.0") && Catch::Contains("Hz"));
    CHECK_THAT(info(configs + "joint-maps/cmu.json").output,
               Catch::Contains("joint map") && Catch::Contains("are driven"));
    CHECK_THAT(info(configs + "joint-limits.json").output,
               Catch::Contains("ranges of motion") && Catch::Contains("1979"));
    CHECK_THAT(info(configs + "smoke.json").output, Catch::Contains("options of tools"));

    std::string cache("POINTCACHE2\0", 12);
    for (const std::int32_t number : {1, 2, 0, 0, 3})  // version, vertices, first frame, step, frames
        cache.append(reinterpret_cast<const char*>(&number), 4);
    write_file(folder.file("x.pc2"), cache + std::string(2 * 3 * 12, '\0'));
    CHECK_THAT(info(folder.file("x.pc2")).output, Catch::Contains("3 of 2 vertices"));
    write_file(folder.file("cut.pc2"), cache + std::string(70, '\0'));
    write_file(folder.file("cut.png"), "\x89PNG\r\n\x1a\n and no more");
    write_file(folder.file("cut.ndg"), "ndg-run");
    write_file(folder.file("cut.pt"), "PK\3\4 and no more");
    write_file(folder.file("cut.html"), "<!DOCTYPE html><html>");
    write_file(folder.file("words.txt"), "no file of ours");
    write_file(folder.file("empty.bin"), "");
    for (const char* name : {"cut.pc2", "cut.png", "cut.ndg", "cut.pt", "cut.html", "words.txt", "empty.bin"}) {
        const CommandResult broken = info(folder.file(name));
        INFO(broken.output);
        CHECK(broken.exit_code == 2);
        CHECK(std::count(broken.output.begin(), broken.output.end(), '\n') == 1);
        CHECK_THAT(broken.output, Catch::StartsWith("ndg-info: error: ") && Catch::Contains(name));
    }
}

TEST_CASE("ndg-info refuses a file of ours that lacks a dataset")
{
    const TemporaryFolder folder;
    PoseSet poses;
    poses.poses = {Pose::rest(num_standard_joints)};
    poses.clip_idx = poses.frame_idx = {0};
    poses.clip_names = {"still"};
    poses.clip_frame_rates = {30};
    write_poses(folder.file("poses.h5"), poses, example_provenance());
    CHECK_THAT(info(folder.file("poses.h5")).output,
               Catch::Contains("poses on our skeleton") && Catch::Contains("1 of 1 clips"));
    run_python("f = h5py.File('" + folder.file("poses.h5") + "', 'r+')\ndel f['/poses/frame_idx']\nf.close()");
    const CommandResult broken = info(folder.file("poses.h5"));
    CHECK(broken.exit_code == 2);
    CHECK_THAT(broken.output, Catch::Contains("/poses/frame_idx is missing"));
}
