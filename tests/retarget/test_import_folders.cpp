// SPDX-License-Identifier: Apache-2.0
// Folders of motions: links, bad files among good ones, several rigs, takes of one name, rates.
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/motion/motion_files.h"
#include "ndg/retarget/import_motions.h"
#include "support/support.h"

#include "retarget/foreign_rig.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>

using namespace ndg;
using namespace ndg::test;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

struct Run {
    ImportedMotions imported;
    std::string told;
};

Run import(const std::vector<std::string>& motions, const MotionImportOptions& options = {},
           const std::vector<std::string>& joint_map = {})
{
    MotionFiles files;
    files.motions = motions;
    files.complete();
    files.joint_map = joint_map;
    Run run;
    run.imported =
        import_motions(files, options, human_joints(), [&](const std::string& line) { run.told += line + "\n"; });
    return run;
}

MotionClip walk(double frame_rate = 0.0)
{
    return built_in_clip("walk", plain_rig(), frame_rate);
}

/// The same steps in mirror image: as long, another motion.
MotionClip other_walk()
{
    MotionClip clip = walk();
    std::reverse(clip.world_from_joint.begin(), clip.world_from_joint.end());
    return clip;
}

std::string in_folder(const TemporaryFolder& folder, const std::string& name)
{
    fs::create_directories(fs::path(folder.file(name)).parent_path());
    return folder.file(name);
}

void write_plain(const std::string& path, const MotionClip& clip, double frame_time = 0.0)
{
    write_bvh(path, clip, own_frames(clip), frame_time);
}

}  // namespace

TEST_CASE("two takes of one name and length are both kept, a copy of another name is not")
{
    const TemporaryFolder folder;
    write_plain(in_folder(folder, "s1/walk.bvh"), walk());
    write_plain(in_folder(folder, "s2/walk.bvh"), other_walk());
    write_plain(in_folder(folder, "s3/stride.bvh"), walk());
    Run run = import({folder.path()});
    CHECK(run.imported.poses.clip_names == std::vector<std::string>{"walk", "s2/walk"});
    CHECK(run.imported.num_copies == 1);
    CHECK_THAT(run.told, Contains("s3/stride.bvh: the same motion as walk"));
    // A take on another rig, with a T pose, is the same take.
    MotionClip turned = walk();
    std::vector<Eigen::Matrix3d> raised(std::size_t(turned.num_joints()), Eigen::Matrix3d::Identity());
    for (int j = 0; j < turned.num_joints(); ++j) {
        const std::string& name = turned.joint_names[std::size_t(j)];
        if (name.find("Arm") == std::string::npos && name.find("Hand") == std::string::npos) continue;
        raised[std::size_t(j)] = about_z(name[0] == 'L' ? 45.0 * degree : -45.0 * degree);
    }
    set_zero_pose(turned, raised);
    for (std::string& name : turned.joint_names) name = "rig:" + name;
    fs::remove(folder.file("s3/stride.bvh"));
    write_plain(folder.file("s3/stride.bvh"), turned);
    run = import({folder.path()});
    CHECK(run.imported.poses.clip_names == std::vector<std::string>{"walk", "s2/walk"});
    CHECK(run.imported.num_copies == 1);
    // Named twice: said, not silent.
    run = import({folder.file("s1/walk.bvh"), folder.file("s1/walk.bvh"), folder.file("s2/walk.bvh")});
    CHECK(run.imported.reports.size() == 2);
    CHECK_THAT(run.told, Contains("skipped " + folder.file("s1/walk.bvh") + ": the same motion as walk"));
}

TEST_CASE("links are followed once, and hidden files passed over")
{
    const TemporaryFolder folder, elsewhere;
    write_plain(in_folder(folder, "a/walk.bvh"), walk());
    write_plain(elsewhere.file("far.bvh"), other_walk());
    write_file(in_folder(folder, "a/._walk.bvh"), "x");
    write_file(in_folder(folder, ".trash/old.bvh"), "x");
    fs::create_directory_symlink(folder.path(), folder.file("a/up"));
    fs::create_directory_symlink(folder.file("a"), folder.file("b"));
    fs::create_directory_symlink(elsewhere.path(), folder.file("c"));
    fs::create_directory_symlink(folder.file("c"), elsewhere.file("back"));
    fs::create_symlink(folder.file("a/walk.bvh"), folder.file("same.bvh"));
    fs::create_symlink(folder.file("nothing"), folder.file("dead.bvh"));
    std::vector<std::string> read, skipped;
    for (const MotionFile& file : find_motion_files({folder.path()})) {
        CHECK(file.error.empty());
        (file.skip_reason.empty() ? read : skipped).push_back(file.path.substr(folder.path().size() + 1));
        if (file.path == folder.file("dead.bvh")) CHECK(file.skip_reason == "a link that leads nowhere");
    }
    CHECK(read == std::vector<std::string>{"a/walk.bvh", "c/far.bvh"});
    std::sort(skipped.begin(), skipped.end());
    CHECK(skipped == std::vector<std::string>{"a/up", "b", "c/back", "dead.bvh", "same.bvh"});
    const Run run = import({folder.path()});
    CHECK(run.imported.reports.size() == 2);
    CHECK_THAT(run.told, Contains("skipped " + folder.file("b") + ": a link to what is read already"));
    CHECK_NOTHROW(run.imported.check());
}

TEST_CASE("bad files among good ones are listed in the end, the good ones are imported")
{
    const TemporaryFolder folder;
    write_plain(in_folder(folder, "a/walk.bvh"), walk());
    write_plain(in_folder(folder, "c/walk.bvh"), other_walk());
    write_file(in_folder(folder, "b/broken.bvh"), "HIERARCHY\nnonsense");
    write_file(in_folder(folder, "b/alone.amc"), "1\n");
    write_file(in_folder(folder, "b/archive.npz"), "x");
    write_file(in_folder(folder, "b/notes.txt"), "no motion at all");
    const Run run = import({folder.path()});
    CHECK(run.imported.reports.size() == 2);
    REQUIRE(run.imported.failures.size() == 3);
    for (const char* name : {"alone.amc: there is no .asf", "archive.npz", "broken.bvh: line 2"})
        CHECK_THROWS_WITH(run.imported.check(), Contains(name) && Contains("3 files could not be read"));
    CHECK_THROWS_AS(run.imported.check(), QualityError);
    CHECK_THAT(run.told, Contains("notes.txt") && Contains("failed "));
    // Named files, and folders without a good one, are wrong input.
    CHECK_THROWS_AS(import({folder.file("a/walk.bvh"), folder.file("b/broken.bvh")}), InputError);
    CHECK_THROWS_WITH(import({folder.file("b")}), Contains("gave no pose") && Contains("alone.amc"));
}

TEST_CASE("several rigs are imported in one run, each by its own map")
{
    const TemporaryFolder folder;
    const MotionClip plain = walk();
    MotionClip odd = other_walk();
    for (std::string& name : odd.joint_names) name = "n" + std::to_string(odd.find_joint(name));
    write_plain(in_folder(folder, "m/plain.bvh"), plain);
    write_plain(in_folder(folder, "m/odd.bvh"), odd);
    Run run = import({folder.file("m")});
    CHECK(run.imported.reports.size() == 1);
    CHECK(run.imported.num_unmapped == 1);
    CHECK_THAT(run.told, Contains("odd.bvh: no joint map fits its joints") && Contains(" lacks \"") &&
                             Contains("propose-joint-map"));
    CHECK_THROWS_WITH(import({folder.file("m/odd.bvh")}), Contains("no joint map fits") && Contains(" lacks \""));
    std::string text = R"({"joints": {)";
    const std::vector<RigJoint> rig = plain_rig();
    for (std::size_t j = 0; j < rig.size(); ++j)
        text += (j > 0 ? ", \"" : "\"") + rig[j].ours + "\": \"n" + std::to_string(j) + "\"";
    write_file(folder.file("odd.json"), text + "}}");
    run = import({folder.file("m")}, {}, {folder.file("odd.json")});
    CHECK(run.imported.reports.size() == 2);
    CHECK(run.imported.num_unmapped == 0);
}

TEST_CASE("implausible rates are refused unless the rate is given")
{
    const TemporaryFolder folder;
    MotionImportOptions options;
    options.retarget.frame_rate = 0.0;
    options.retarget.max_joint_speed = 1e9;
    for (const double frame_time : {33.3, 1e-300, 8.33, 1e-5}) {
        INFO(frame_time);
        write_plain(folder.file("walk.bvh"), walk(), frame_time);
        options.source_rate = 0.0;
        CHECK_THROWS_WITH(import({folder.file("walk.bvh")}, options),
                          Contains("walk.bvh: its frames are") && Contains("--source-rate"));
        options.source_rate = 30.0;
        const Run run = import({folder.file("walk.bvh")}, options);
        CHECK(run.imported.poses.clip_frame_rates == std::vector<double>{30.0});
        CHECK(run.imported.reports[0].frame_rate == 30.0);
    }
    options.source_rate = 0.0;
    write_plain(folder.file("walk.bvh"), walk(), 1.0 / 120.0);
    CHECK(import({folder.file("walk.bvh")}, options).imported.reports[0].frame_rate == Approx(120.0));
    // Half as many frames a second are half as many poses a second of them.
    options.retarget.frame_rate = 10.0;
    options.source_rate = 20.0;
    const int slow = import({folder.file("walk.bvh")}, options).imported.poses.size();
    options.source_rate = 40.0;
    CHECK(import({folder.file("walk.bvh")}, options).imported.poses.size() == Approx(slow / 2).margin(1));
}
