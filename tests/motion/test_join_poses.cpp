// SPDX-License-Identifier: Apache-2.0
#include "ndg/motion/join_poses.h"
#include "ndg/motion/same_motion.h"

#include "ndg/geometry/rotation.h"
#include "ndg/motion/keyframes.h"
#include "support/support.h"

#include "motion/human.h"

#include <catch2/catch.hpp>

#include <algorithm>

using namespace ndg;
using namespace ndg::test;

namespace {

PoseSet motion(const std::string& name, double poses_per_second = 10.0)
{
    return keyframe_poses(read_keyframe_motion(config_path("motions/" + name + ".json")), human_joints(),
                          poses_per_second);
}

bool same(const PoseSet& a, const PoseSet& b, const SameMotionOptions& options)
{
    return same_motion({&a, 0, a.size()}, {&b, 0, b.size()}, options);
}

}  // namespace

TEST_CASE("joined pose files keep poses, clips and what poses are spliced from")
{
    PoseSet walk = motion("walk"), squat = motion("squat");
    squat.spliced_from = RowMatrixI::Constant(squat.size(), 6, -1);
    squat.spliced_from.row(1) << 0, 3, 0, 4, 0, 5;
    squat.covering_radius.assign(std::size_t(squat.size()), 1.0);
    const PoseSet joined = join_poses({walk, squat, walk});
    REQUIRE(joined.size() == 2 * walk.size() + squat.size());
    CHECK(joined.clip_names == std::vector<std::string>{"walk", "squat", "walk 2"});
    CHECK(joined.clip_frame_rates == std::vector<double>{60.0, 30.0, 60.0});
    CHECK(joined.covering_radius.empty());
    // The spliced pose of the second file comes last.
    const int third = walk.size() + squat.size() - 1, last = joined.size() - 1;
    CHECK(joined.clip_idx[std::size_t(walk.size())] == 1);
    CHECK(joined.frame_idx[std::size_t(walk.size()) + 1] == squat.frame_idx[2]);
    CHECK(joined.clip_idx[std::size_t(third)] == 2);
    CHECK(joined.frame_idx[std::size_t(third) + 2] == walk.frame_idx[2]);
    CHECK(joined.poses[std::size_t(third) + 2].parent_from_joint == walk.poses[2].parent_from_joint);
    CHECK_FALSE(joined.is_spliced(last - 1));
    REQUIRE(joined.is_spliced(last));
    CHECK(joined.clip_idx[std::size_t(last)] == 1);
    CHECK(joined.poses[std::size_t(last)].parent_from_joint == squat.poses[1].parent_from_joint);
    CHECK(joined.spliced_from.row(last) == (Eigen::Matrix<int, 1, 6>() << 1, 3, 1, 4, 1, 5).finished());
    // As a file, which checks all indices.
    const TemporaryFolder folder;
    write_poses(folder.file("joined.h5"), joined, {});
    CHECK(read_poses(folder.file("joined.h5")).size() == joined.size());
}

TEST_CASE("a motion is the same as itself, also a pose later or a little elsewhere, and as no other")
{
    const PoseSet walk = motion("walk");
    CHECK(same(walk, walk, same_rig()));
    CHECK(same(walk, walk, other_rig()));
    PoseSet later = walk;
    later.poses.erase(later.poses.begin());
    CHECK_FALSE(same(walk, later, same_rig()));
    CHECK(same(walk, later, other_rig()));
    PoseSet bent = walk, far = walk;
    for (Pose& pose : bent.poses) {
        for (const char* joint : {"left_thigh", "right_upper_arm", "left_forearm"})
            pose.parent_from_joint[std::size_t(standard_skeleton().joint(joint))] *= about_x(3.0 * degree);
        pose.root_translation.x() += 1.0;
    }
    CHECK_FALSE(same(walk, bent, same_rig()));
    CHECK(same(walk, bent, other_rig()));
    for (std::size_t k = 0; k < far.poses.size(); ++k) far.poses[k].root_translation.z() += 0.1 * double(k);
    CHECK_FALSE(same(walk, far, other_rig()));
    PoseSet reversed = walk;
    std::reverse(reversed.poses.begin(), reversed.poses.end());
    CHECK_FALSE(same(walk, reversed, other_rig()));
    for (const char* name : {"run", "squat", "reach"}) CHECK_FALSE(same(walk, motion(name), other_rig()));
}
