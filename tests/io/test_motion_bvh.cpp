// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/io/motion.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <fstream>

using namespace ndg;
using Catch::Matchers::Contains;

namespace {

const std::string hierarchy = R"(HIERARCHY
ROOT Hips
{
	OFFSET 9 9 9
	CHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation
	JOINT Knee
	{
		OFFSET 0 -2 0
		CHANNELS 3 Xrotation Zrotation Yrotation
		End Site
		{
			OFFSET 0 -1 0.5
		}
	}
	JOINT Chest
	{
		OFFSET 0 3 0
		CHANNELS 0
	}
}
MOTION
)";
const std::string motion = "Frames: 2\r\nFrame Time: .0083333\r\n1 2 3 0 0 0 0 0 0\r\n4 5 6 10 20 30 40 50 60\r\n";

std::string write(const test::TemporaryFolder& folder, const std::string& content)
{
    std::ofstream(folder.file("clip.bvh"), std::ios::binary) << content;
    return folder.file("clip.bvh");
}

std::string replaced(std::string text, const std::string& what, const std::string& by)
{
    const std::size_t at = text.find(what);
    REQUIRE(at != std::string::npos);
    return text.replace(at, what.size(), by);
}

/// Rotation matrices written out, independently of the reader.
Eigen::Matrix3d rotation(char axis, double degrees)
{
    const double c = std::cos(degrees * M_PI / 180), s = std::sin(degrees * M_PI / 180);
    Eigen::Matrix3d m;
    if (axis == 'x') m << 1, 0, 0, 0, c, -s, 0, s, c;
    if (axis == 'y') m << c, 0, s, 0, 1, 0, -s, 0, c;
    if (axis == 'z') m << c, -s, 0, s, c, 0, 0, 0, 1;
    return m;
}

}  // namespace

TEST_CASE("a BVH file is read with its channel order, zero pose and positions")
{
    const test::TemporaryFolder folder;
    const MotionClip clip = read_bvh(write(folder, hierarchy + motion));
    CHECK(clip.name == "clip");
    CHECK(clip.joint_names == std::vector<std::string>{"Hips", "Knee", "Chest"});
    CHECK(clip.parents == std::vector<int>{-1, 0, 0});
    CHECK(clip.frame_rate == Approx(120.0).epsilon(1e-5));
    CHECK_FALSE(clip.frame_rate_assumed);
    REQUIRE(clip.num_frames() == 2);
    CHECK(clip.find_joint("Chest") == 2);
    CHECK(clip.find_joint("Elbow") == -1);
    CHECK(clip.zero_pose_positions.row(0).norm() == 0.0);
    CHECK((clip.zero_pose_positions.row(1) - Eigen::RowVector3d(0, -2, 0)).norm() == 0.0);
    CHECK((clip.zero_pose_tips.row(1) - Eigen::RowVector3d(0, -3, 0.5)).norm() == 0.0);
    CHECK((clip.zero_pose_tips.row(0) - Eigen::RowVector3d(0, 0.5, 0)).norm() < 1e-15);

    for (const Eigen::Matrix3d& r : clip.world_from_joint[0]) CHECK((r - Eigen::Matrix3d::Identity()).norm() == 0.0);
    CHECK((clip.root_positions.row(0) - Eigen::RowVector3d(1, 2, 3)).norm() == 0.0);

    const Eigen::Matrix3d root = rotation('z', 10) * rotation('y', 20) * rotation('x', 30);
    const Eigen::Matrix3d knee = root * rotation('x', 40) * rotation('z', 50) * rotation('y', 60);
    CHECK((clip.world_from_joint[1][0] - root).norm() < 1e-14);
    CHECK((clip.world_from_joint[1][1] - knee).norm() < 1e-14);
    CHECK((clip.world_from_joint[1][2] - root).norm() < 1e-14);
    const Eigen::Vector3d position = Eigen::Vector3d(4, 5, 6) + root * Eigen::Vector3d(0, -2, 0);
    CHECK((clip.joint_positions(1).row(1).transpose() - position).norm() < 1e-14);
}

TEST_CASE("position channels of joints other than the root are read over")
{
    const test::TemporaryFolder folder;
    const std::string six = replaced(hierarchy, "CHANNELS 3 Xrotation Zrotation Yrotation",
                                     "CHANNELS 6 Xposition Yposition Zposition Xrotation Zrotation Yrotation");
    const MotionClip clip =
        read_bvh(write(folder, six + "Frames: 1\nFrame Time: 0.1\n1 2 3 0 0 0 0.1 0.2 0.3 90 0 0\n"));
    CHECK((clip.joint_positions(0).row(1) - Eigen::RowVector3d(1, 0, 3)).norm() < 1e-14);
    CHECK((clip.world_from_joint[0][1] - rotation('x', 90)).norm() < 1e-14);
}

TEST_CASE("a malformed BVH file is refused with file, line and value")
{
    const test::TemporaryFolder folder;
    const auto check = [&](const std::string& content, const std::string& message) {
        const std::string path = write(folder, content);
        CHECK_THROWS_AS(read_bvh(path), InputError);
        CHECK_THROWS_WITH(read_bvh(path), Contains(path) && Contains(message));
    };
    check("", "is empty");
    check(replaced(hierarchy, "JOINT Knee", "BONE Knee") + motion, "line 6: unknown keyword 'BONE'");
    check(replaced(hierarchy, "OFFSET 0 -2 0", "OFFSET 0 -2 zero") + motion, "line 8: OFFSET is 'zero', not a number");
    check(replaced(hierarchy, "Zrotation Yrotation\n", "Zrotation Wrotation\n") + motion,
          "unknown channel 'Wrotation'");
    check(replaced(hierarchy, "JOINT Chest", "JOINT Knee") + motion, "joint 'Knee' appears twice");
    check(hierarchy.substr(0, 150), "the file ends where");
    check(replaced(hierarchy, "OFFSET 0 3 0\n", "") + motion, "joint 'Chest' has no OFFSET");
    check(hierarchy + replaced(motion, "Frames: 2", "Frames: 0"), "has 0 frames");
    check(hierarchy + replaced(motion, "Frames: 2", "Frames: 3"), "announces 3 frames and ends after 2");
    check(hierarchy + replaced(motion, "Frames: 2", "Frames: 1"), "more frames than the 1 announced");
    check(hierarchy + replaced(motion, ".0083333", "0"), "Frame Time is 0");
    check(hierarchy + replaced(motion, "10 20 30 40", "10 20 30"),
          "frame 1 has 8 values, the hierarchy has 9 channels");
    check(hierarchy + replaced(motion, "10 20 30 40", "10 nan 30 40"), "value 4 of frame 1 is 'nan', not a finite");
    CHECK_THROWS_WITH(read_bvh(folder.file("none.bvh")), Contains("none.bvh: does not exist"));
}
