// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/io/motion.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;
using Catch::Matchers::Contains;

namespace {

const std::string character = R"({"Skeleton": {"Joints": [
{"ID": 0, "Name": "root", "Type": "none", "Parent": -1, "AttachX": 0, "AttachY": 0, "AttachZ": 0},
{"ID": 1, "Name": "chest", "Type": "spherical", "Parent": 0, "AttachX": 0, "AttachY": 0.5, "AttachZ": 0},
{"ID": 2, "Name": "arm", "Type": "revolute", "Parent": 1, "AttachX": 0, "AttachY": 0.25, "AttachZ": 0.2},
{"ID": 3, "Name": "hand", "Type": "fixed", "Parent": 2, "AttachX": 0, "AttachY": -0.3, "AttachZ": 0}]},
"BodyDefs": [{"ID": 3, "Name": "hand", "AttachX": 0.1, "AttachY": 0, "AttachZ": 0, "AttachThetaX": 0},
{"ID": 1, "Name": "chest", "AttachX": 9, "AttachY": 9, "AttachZ": 9}]})";

// Quarter turns; the quaternion of the root is twice as long as it should be, which published clips come near to.
const std::string motion = R"({
"Loop": "wrap",
"Frames":
[
[0.5, 1, 2, 3, 1.4142135623730951, 0, 1.4142135623730951, 0, 0.7071067811865476, 0.7071067811865476, 0, 0, 1.5707963267948966],
[0.5, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0],
[0.0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0]
]
})";

struct Files {
    test::TemporaryFolder folder;
    MotionClip read(const std::string& skeleton, const std::string& frames) const
    {
        write_file(folder.file("c_character.json"), skeleton);
        write_file(folder.file("c_take.txt"), frames);
        return read_deepmimic(folder.file("c_character.json"), folder.file("c_take.txt"));
    }
};

std::string replaced(std::string text, const std::string& what, const std::string& by)
{
    const std::size_t at = text.find(what);
    REQUIRE(at != std::string::npos);
    return text.replace(at, what.size(), by);
}

}  // namespace

TEST_CASE("DeepMimic clips are read and turned to face +z")
{
    const Files files;
    const MotionClip clip = files.read(character, motion);
    CHECK(clip.name == "c_take");
    CHECK(clip.joint_names == std::vector<std::string>{"root", "chest", "arm", "hand"});
    CHECK(clip.parents == std::vector<int>{-1, 0, 1, 2});
    CHECK(clip.frame_rate == 2.0);
    CHECK_FALSE(clip.frame_rate_assumed);
    REQUIRE(clip.num_frames() == 3);
    // The file's x is our z, its z our -x.
    CHECK((clip.zero_pose_positions.row(2) - Eigen::RowVector3d(-0.2, 0.75, 0)).norm() < 1e-15);
    CHECK((clip.zero_pose_tips.row(3) - Eigen::RowVector3d(-0.2, 0.45, 0.1)).norm() < 1e-15);
    CHECK((clip.zero_pose_tips.row(1) - clip.zero_pose_positions.row(2)).norm() < 1e-15);
    CHECK((clip.root_positions.row(0) - Eigen::RowVector3d(-3, 2, 1)).norm() < 1e-15);

    // The root turns left by 90 degrees; the chest by 90 about the file's x, which is our z; the arm by 90 about the
    // file's z, which is our -x.
    Eigen::Matrix3d root, chest, arm;
    root << 0, 0, 1, 0, 1, 0, -1, 0, 0;
    chest << 0, -1, 0, 1, 0, 0, 0, 0, 1;
    arm << 1, 0, 0, 0, 0, 1, 0, -1, 0;
    CHECK((clip.world_from_joint[0][0] - root).norm() < 1e-12);
    CHECK((clip.world_from_joint[0][1] - root * chest).norm() < 1e-12);
    CHECK((clip.world_from_joint[0][2] - root * chest * arm).norm() < 1e-12);
    CHECK((clip.world_from_joint[0][3] - root * chest * arm).norm() < 1e-12);
    for (int j = 0; j < 4; ++j) CHECK((clip.world_from_joint[1][j] - Eigen::Matrix3d::Identity()).norm() < 1e-15);
}

TEST_CASE("malformed DeepMimic files are refused with file, item and value")
{
    const Files files;
    const auto check = [&](const std::string& skeleton, const std::string& frames, const std::string& message) {
        INFO(message);
        CHECK_THROWS_AS(files.read(skeleton, frames), InputError);
        CHECK_THROWS_WITH(files.read(skeleton, frames), Contains(files.folder.path()) && Contains(message));
    };
    check(character, motion.substr(0, 120), "not valid JSON");
    check(character, "[1]", "c_take.txt: expected an object, got [1]");
    check(character, "{\"Loop\": \"wrap\"}", "has no \"Frames\"");
    check(character, "{\"Frames\": []}", "has no frames");
    check(character, "{\"Frames\": [3]}", "Frames[0]: expected a list of 13, got 3");
    check(character, replaced(motion, ", 1.5707963267948966]", "]"), "Frames[0]: expected a list of 13, got [");
    check(character, replaced(motion, "1, 2, 3", "1, null, 3"), "Frames[0][2]: expected a number, got null");
    check(character, replaced(motion, "1, 2, 3", "1, NaN, 3"), "not valid JSON");
    check(character, replaced(motion, "1, 2, 3", "1, 1e999, 3"), "not valid JSON");
    check(character, replaced(motion, "0, 1, 0, 0, 0, 0]", "0, 0.1, 0, 0, 0, 0]"),
          "the quaternion of \"chest\" in frame 1 has norm 0.1");
    check(character, replaced(motion, "[0.5, 1", "[-0.5, 1"), "the duration of frame 0 is -0.5");
    check(character, "{\"Frames\": [[0, 0,0,0, 1,0,0,0, 1,0,0,0, 0]]}", "gives no frame rate");
    check("{}", motion, "c_character.json: has no \"Skeleton\"");
    check(replaced(character, "revolute", "planar"), motion,
          "Skeleton.Joints[2].Type: expected one of spherical | revolute | fixed, got \"planar\"");
    check(replaced(character, "\"Parent\": 1", "\"Parent\": 2"), motion,
          "Skeleton.Joints[2].Parent: expected an integer in [0, 1], got 2");
    check(replaced(character, "\"ID\": 2", "\"ID\": 7"), motion, "Skeleton.Joints[2].ID: expected 2, got 7");
    check(replaced(character, "\"arm\"", "\"chest\""), motion, "two joints are named \"chest\"");
    check(replaced(character, "\"AttachY\": 0.25", "\"AttachY\": \"a\""), motion,
          "Skeleton.Joints[2].AttachY: expected a number, got \"a\"");
    check(replaced(character, "\"AttachZ\": 0.2}", "\"AttachZ\": 0.2, \"AttachThetaX\": 0.1}"), motion,
          "Skeleton.Joints[2].AttachThetaX: expected 0 (joints at an angle are not supported), got 0.1");
    CHECK_THROWS_AS(read_deepmimic(files.folder.file("none.json"), files.folder.file("c_take.txt")), InputError);
}
