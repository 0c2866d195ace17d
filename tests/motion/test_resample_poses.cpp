// SPDX-License-Identifier: Apache-2.0
#include "ndg/motion/resample_poses.h"

#include "ndg/core/error.h"
#include "ndg/geometry/rotation.h"

#include "motion/human.h"

#include <catch2/catch.hpp>

using namespace ndg;
using namespace ndg::test;

namespace {

/// A forearm that turns about x by `degrees_per_frame`, the root that moves along z, at `frame_rate`.
PoseSet turning(const std::vector<int>& frames, double degrees_per_frame, double frame_rate)
{
    PoseSet poses;
    poses.clip_names = {"turning"};
    poses.clip_frame_rates = {frame_rate};
    for (const int f : frames) {
        Pose pose = Pose::rest(num_standard_joints);
        pose.parent_from_joint[standard_skeleton().joint("left_forearm")] = about_x(f * degrees_per_frame * degree);
        pose.root_translation.z() = 0.1 * f;
        poses.poses.push_back(pose);
        poses.clip_idx.push_back(0);
        poses.frame_idx.push_back(f);
    }
    return poses;
}

bool same(const Pose& a, const Pose& b)
{
    return a.parent_from_joint == b.parent_from_joint && a.root_translation == b.root_translation;
}

/// Degrees by which the forearm is away from a turn of `degrees`.
double away(const Pose& pose, double degrees)
{
    return rotation_angle(pose.parent_from_joint[standard_skeleton().joint("left_forearm")],
                          about_x(degrees * degree)) /
           degree;
}

}  // namespace

TEST_CASE("A constant turn stays one at any rate, up and down, beyond half a turn too")
{
    const PoseSet poses = turning({0, 1, 2, 3, 4, 5, 6, 7, 8}, 50.0, 24.0);
    for (const double rate : {24.0, 60.0, 7.0, 25.0}) {
        CAPTURE(rate);
        const PoseSet result = resample_poses(poses, rate);
        CHECK(result.clip_frame_rates == std::vector<double>{rate});
        REQUIRE(result.size() == int(8.0 / 24.0 * rate + 1e-6) + 1);
        for (int f = 0; f < result.size(); ++f) {
            const double time = f * 24.0 / rate;
            CHECK(away(result.poses[f], 50.0 * time) < 1e-6);
            CHECK(result.poses[f].root_translation.z() == Approx(0.1 * time).margin(1e-12));
            CHECK(result.frame_idx[f] == f);
        }
    }
}

TEST_CASE("Poses at their own times are the poses, and those that are missing are filled in")
{
    const PoseSet poses = turning({3, 4, 6, 7}, 10.0, 30.0);
    const PoseSet result = resample_poses(poses, 0.0);
    REQUIRE(result.size() == 5);
    CHECK(result.clip_frame_rates == poses.clip_frame_rates);
    CHECK(same(result.poses[0], poses.poses[0]));
    CHECK(same(result.poses[1], poses.poses[1]));
    CHECK(away(result.poses[2], 50.0) < 1e-6);
    CHECK(same(result.poses[3], poses.poses[2]));
    CHECK(same(result.poses[4], poses.poses[3]));
    const PoseSet doubled = resample_poses(poses, 60.0);
    REQUIRE(doubled.size() == 9);
    CHECK(same(doubled.poses[8], poses.poses[3]));
    CHECK(away(doubled.poses[7], 65.0) < 1e-6);
}

TEST_CASE("The shorter way round is taken")
{
    const PoseSet result = resample_poses(turning({0, 1}, -170.0, 10.0), 20.0);
    REQUIRE(result.size() == 3);
    CHECK(away(result.poses[1], -85.0) < 1e-6);
}

TEST_CASE("One pose stays one, none stays none, several clips are not one")
{
    CHECK(resample_poses(turning({5}, 10.0, 30.0), 120.0).size() == 1);
    const PoseSet none = resample_poses(turning({}, 10.0, 30.0), 120.0);
    CHECK(none.size() == 0);
    CHECK(none.clip_names.size() == 1);
    PoseSet two = turning({0, 1}, 10.0, 30.0);
    two.clip_names.push_back("another");
    CHECK_THROWS_AS(resample_poses(two, 10.0), Error);
}
