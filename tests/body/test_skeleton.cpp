// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/skeleton.h"
#include "ndg/core/error.h"
#include "ndg/core/random.h"

#include <catch2/catch.hpp>

#include <set>

using namespace ndg;

namespace {

Eigen::Matrix3d rotation(double angle, const Eigen::Vector3d& axis)
{
    return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

Points random_positions(int count)
{
    Random random(7, "joints");
    Points points(count, 3);
    for (Eigen::Index i = 0; i < points.size(); ++i) points.data()[i] = random.uniform(-1.0, 1.0);
    return points;
}

Pose random_pose(int count)
{
    Random random(8, "pose");
    Pose pose = Pose::rest(count);
    for (Eigen::Matrix3d& matrix : pose.parent_from_joint) {
        matrix = rotation(random.uniform(-3.0, 3.0), {random.normal(), random.normal(), random.normal()});
    }
    pose.root_translation = {0.3, -0.2, 0.7};
    return pose;
}

/// 4 x 4 rotation about a point.
Eigen::Matrix4d about(const Eigen::Matrix3d& matrix, const Eigen::Vector3d& centre)
{
    Eigen::Matrix4d to = Eigen::Matrix4d::Identity(), turn = to, back = to;
    to.topRightCorner<3, 1>() = centre;
    turn.topLeftCorner<3, 3>() = matrix;
    back.topRightCorner<3, 1>() = -centre;
    return to * turn * back;
}

}  // namespace

TEST_CASE("The standard skeleton has 60 distinct joints, parents first, left and right alike", "[skeleton]")
{
    const Skeleton& skeleton = standard_skeleton();
    REQUIRE(skeleton.num_joints() == 60);
    REQUIRE(skeleton.parents.size() == 60);
    CHECK(std::set<std::string>(skeleton.joint_names.begin(), skeleton.joint_names.end()).size() == 60);
    CHECK(skeleton.parents[0] == -1);
    const std::vector<std::string> first = {"pelvis", "spine_1", "spine_2", "spine_3", "spine_4",  "spine_5",
                                            "neck_1", "neck_2",  "head",    "jaw",     "left_eye", "right_eye"};
    CHECK(std::vector<std::string>(skeleton.joint_names.begin(), skeleton.joint_names.begin() + 12) == first);
    CHECK(skeleton.joint("left_clavicle") == 12);
    CHECK(skeleton.joint("left_thumb_1") == 17);
    CHECK(skeleton.joint("left_pinky_3") == 31);
    CHECK(skeleton.joint("left_toes") == 35);
    CHECK(skeleton.joint("right_clavicle") == 36);
    CHECK(skeleton.joint("right_toes") == 59);

    const auto parent_name = [&](const std::string& name) {
        const int parent = skeleton.parents[skeleton.joint(name)];
        return skeleton.joint_names[parent];
    };
    CHECK(parent_name("neck_1") == "spine_5");
    CHECK(parent_name("left_clavicle") == "spine_5");
    CHECK(parent_name("left_hand") == "left_forearm_twist");
    CHECK(parent_name("right_ring_1") == "right_hand");
    CHECK(parent_name("right_ring_3") == "right_ring_2");
    CHECK(parent_name("left_thigh") == "pelvis");
    CHECK(parent_name("jaw") == "head");
    for (int j = 1; j < 60; ++j) {
        const std::string& name = skeleton.joint_names[j];
        CHECK(skeleton.parents[j] >= 0);
        CHECK(skeleton.parents[j] < j);
        if (name.rfind("left_", 0) != 0) continue;
        std::string mirrored_parent = parent_name(name);
        if (mirrored_parent.rfind("left_", 0) == 0) mirrored_parent.replace(0, 4, "right");
        CHECK(parent_name("right" + name.substr(4)) == mirrored_parent);
    }
    CHECK_THROWS_AS(skeleton.joint("tail"), Error);
}

TEST_CASE("The rest pose moves nothing", "[skeleton]")
{
    for (const Eigen::Isometry3d& motion :
         forward_kinematics(standard_skeleton(), random_positions(60), Pose::rest(60))) {
        CHECK((motion.matrix() - Eigen::Matrix4d::Identity()).norm() < 1e-14);
    }
}

TEST_CASE("A bent joint turns its own side of the body about itself", "[skeleton]")
{
    const Skeleton& skeleton = standard_skeleton();
    const Points positions = random_positions(60);
    const int shin = skeleton.joint("left_shin"), foot = skeleton.joint("left_foot");
    Pose pose = Pose::rest(60);
    const Eigen::Matrix3d bend = rotation(0.8, {1, 0, 0});
    pose.parent_from_joint[shin] = bend;
    const auto motions = forward_kinematics(skeleton, positions, pose);

    const Eigen::Vector3d knee = positions.row(shin).transpose(), point(0.1, 0.2, 0.3);
    const Eigen::Vector3d expected = knee + bend * (point - knee);
    CHECK((motions[shin] * point - expected).norm() < 1e-14);
    CHECK((motions[foot] * point - expected).norm() < 1e-14);
    CHECK((motions[skeleton.joint("left_thigh")] * point - point).norm() < 1e-15);
    CHECK((motions[skeleton.joint("right_foot")] * point - point).norm() < 1e-15);
}

TEST_CASE("Motions of a chain are products of rotations about rest joints", "[skeleton]")
{
    const Skeleton& skeleton = standard_skeleton();
    const Points positions = random_positions(60);
    const Pose pose = random_pose(60);
    const auto motions = forward_kinematics(skeleton, positions, pose);
    for (int j = 0; j < 60; ++j) {
        Eigen::Matrix4d expected = Eigen::Matrix4d::Identity();
        for (int k = j; k >= 0; k = skeleton.parents[k]) {
            expected = about(pose.parent_from_joint[k], positions.row(k).transpose()) * expected;
        }
        expected.topRightCorner<3, 1>() += pose.root_translation;
        CHECK((motions[j].matrix() - expected).norm() < 1e-12);
    }
}

TEST_CASE("Forward kinematics refuses a pose or joints of another skeleton", "[skeleton]")
{
    CHECK_THROWS_AS(forward_kinematics(standard_skeleton(), random_positions(59), Pose::rest(60)), Error);
    CHECK_THROWS_AS(forward_kinematics(standard_skeleton(), random_positions(60), Pose::rest(61)), Error);
}
