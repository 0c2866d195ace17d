// SPDX-License-Identifier: Apache-2.0
#include "ndg/retarget/import_motions.h"

#include "ndg/core/error.h"
#include "ndg/core/installed_files.h"
#include "ndg/motion/keyframes.h"
#include "support/support.h"

#include "motion/human.h"

#include <catch2/catch.hpp>

#include <filesystem>

using namespace ndg;
using namespace ndg::test;
using Catch::Matchers::Contains;

namespace {

ImportedMotions import(const std::vector<std::string>& paths, const MotionImportOptions& options,
                       std::string* told = nullptr)
{
    MotionFiles files;
    files.motions = paths;
    files.complete();
    return import_motions(files, options, human_joints(), [&](const std::string& line) {
        if (told != nullptr) *told += line + "\n";
    });
}

}  // namespace

TEST_CASE("Joint maps and limits of the project are found from where the program lies")
{
    const auto same = [](const std::string& found, const std::string& name) {
        return std::filesystem::equivalent(found, config_path(name));
    };
    CHECK(same(installed_path("joint-maps"), "joint-maps"));
    CHECK(installed_path("no such thing").empty());
    MotionFiles files;
    files.complete();
    CHECK(same(files.joint_maps, "joint-maps"));
    CHECK(same(files.joint_limits, "joint-limits.json"));
    files = MotionFiles();
    files.joint_map = {"own.json"};
    files.complete();
    CHECK(files.joint_maps.empty());
}

TEST_CASE("Keyframes between frames are evaluated there, not interpolated")
{
    const std::string squat = config_path("motions/squat.json");
    MotionImportOptions options;
    options.retarget.frame_rate = 100.0;
    CHECK(import({squat}, options).poses.clip_frame_rates == std::vector<double>{30.0});
    options.interpolate = true;
    const ImportedMotions imported = import({squat}, options);
    KeyframeMotion motion = read_keyframe_motion(squat);
    motion.frame_rate = 100.0;
    const PoseSet expected = keyframe_poses(motion, human_joints(), 0.0);
    REQUIRE(imported.poses.size() == expected.size());
    CHECK(imported.poses.clip_frame_rates == std::vector<double>{100.0});
    for (int f = 0; f < expected.size(); ++f)
        CHECK(imported.poses.poses[f].parent_from_joint == expected.poses[f].parent_from_joint);
    CHECK(imported.num_own == 1);
    CHECK_THAT(imported.licences, Contains("Apache-2.0"));
}

TEST_CASE("A take that is named twice is read once, and what gives no pose is named")
{
    const std::string squat = config_path("motions/squat.json"), walk = config_path("motions/walk.json");
    std::string told;
    const ImportedMotions imported = import({squat, walk, squat}, {}, &told);
    CHECK(imported.poses.clip_names == std::vector<std::string>{"squat", "walk"});
    CHECK(imported.num_copies == 1);
    CHECK_THAT(told, Contains("skipped " + squat));
    CHECK_THROWS_WITH(import({config_path("smoke.json")}, {}), Contains("smoke.json"));
    const TemporaryFolder empty;
    CHECK_THROWS_WITH(import({empty.path()}, {}), Contains("no pose"));
    MotionImportOptions clamping;
    clamping.retarget.clamp_limits = true;
    MotionFiles files;
    files.motions = {squat};
    CHECK_THROWS_AS(import_motions(files, clamping, human_joints(), [](const std::string&) {}), InputError);
}
