// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/geometry/rotation.h"
#include "ndg/retarget/inverse_kinematics.h"
#include "ndg/retarget/retarget_transfer.h"

#include "motion/human.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;
using namespace ndg::test;

namespace {

using Rotations = std::vector<Eigen::Matrix3d>;

std::vector<int> joints(const std::vector<std::string>& names)
{
    std::vector<int> indices;
    for (const std::string& name : names) indices.push_back(standard_skeleton().joint(name));
    return indices;
}

const std::vector<std::string> free_names = {"pelvis",     "spine_2",        "spine_5",      "neck_1",
                                             "head",       "left_upper_arm", "left_forearm", "left_hand",
                                             "left_thigh", "left_shin",      "left_foot",    "right_clavicle"};
const std::vector<std::string> goal_names = {"neck_1",    "head",      "left_forearm",    "left_hand",   "left_shin",
                                             "left_foot", "left_toes", "right_upper_arm", "left_index_2"};

Eigen::Vector3d random_vector(Random& random, double size)
{
    return size * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
}

/// World rotations with the free joints turned at random, the others with their parents.
Rotations random_rotations(Random& random, double size, const std::vector<int>& free)
{
    Rotations world(num_standard_joints, Eigen::Matrix3d::Identity());
    for (int j = 0; j < num_standard_joints; ++j) {
        const int parent = standard_skeleton().parents[j];
        if (parent >= 0) world[j] = world[parent];
        if (std::find(free.begin(), free.end(), j) != free.end()) {
            world[j] = rotation_of(random_vector(random, size)) * world[j];
        }
    }
    return world;
}

}  // namespace

TEST_CASE("goals that are no joints below free ones are refused")
{
    CHECK_THROWS_AS(InverseKinematics(standard_skeleton(), human_joints(), {1, 2}, {3}), Error);
}

TEST_CASE("goal positions are those of forward kinematics")
{
    Random random(1, "kinematics");
    const Points rest = human_joints();
    const std::vector<int> free = joints(free_names);
    const InverseKinematics kinematics(standard_skeleton(), rest, free, joints(goal_names));
    const Rotations world = random_rotations(random, 0.7, free);
    Pose pose = Pose::rest(num_standard_joints);
    pose.parent_from_joint = local_rotations(world);
    const Points posed = posed_joints(rest, pose);
    const Points positions = kinematics.positions(world);
    for (std::size_t g = 0; g < goal_names.size(); ++g) {
        const int joint = standard_skeleton().joint(goal_names[g]);
        CHECK((posed.row(joint) - posed.row(0) - positions.row(g)).norm() < 1e-12);
    }
    const Rotations again = compose_rotations(pose.parent_from_joint);
    for (int j = 0; j < num_standard_joints; ++j) CHECK((again[j] - world[j]).norm() < 1e-12);
}

TEST_CASE("the analytic Jacobian is the derivative of the positions")
{
    Random random(2, "kinematics");
    const std::vector<int> free = joints(free_names);
    const InverseKinematics kinematics(standard_skeleton(), human_joints(), free, joints(goal_names));
    const Rotations world = random_rotations(random, 0.9, free);
    const RowMatrix jacobian = kinematics.jacobian(world);
    REQUIRE(jacobian.rows() == 3 * Eigen::Index(goal_names.size()));
    REQUIRE(jacobian.cols() == 3 * Eigen::Index(free.size()));
    CHECK(jacobian.norm() > 1.0);
    constexpr double h = 1e-5;
    for (std::size_t i = 0; i < free.size(); ++i) {
        for (int k = 0; k < 3; ++k) {
            Rotations forth = world, back = world;
            forth[free[i]] = rotation_of(h * Eigen::Vector3d::Unit(k)) * world[free[i]];
            back[free[i]] = rotation_of(-h * Eigen::Vector3d::Unit(k)) * world[free[i]];
            const Points difference = (kinematics.positions(forth) - kinematics.positions(back)) / (2 * h);
            for (Eigen::Index g = 0; g < difference.rows(); ++g) {
                for (Eigen::Index d = 0; d < 3; ++d) {
                    CHECK(jacobian(3 * g + d, Eigen::Index(3 * i) + k) == Approx(difference(g, d)).margin(1e-9));
                }
            }
        }
    }
}

TEST_CASE("a solution is a minimum of the objective")
{
    Random random(3, "kinematics");
    const std::vector<int> free = joints(free_names);
    const InverseKinematics kinematics(standard_skeleton(), human_joints(), free, joints(goal_names));
    const Rotations reference = random_rotations(random, 0.5, free);
    Points targets = kinematics.positions(reference);
    for (Eigen::Index g = 0; g < targets.rows(); ++g) targets.row(g) += random_vector(random, 0.03).transpose();
    Rotations world = reference;
    const double before = kinematics.objective(world, reference, targets);
    const int steps = kinematics.solve(reference, targets, world);
    CHECK(steps > 1);
    const double value = kinematics.objective(world, reference, targets);
    CHECK(value < 0.6 * before);
    // No direction leads further down, by differences that know nothing of the gradient.
    constexpr double h = 1e-4;
    for (const int j : free) {
        for (int k = 0; k < 3; ++k) {
            Rotations forth = world, back = world;
            forth[j] = rotation_of(h * Eigen::Vector3d::Unit(k)) * world[j];
            back[j] = rotation_of(-h * Eigen::Vector3d::Unit(k)) * world[j];
            const double up = kinematics.objective(forth, reference, targets);
            const double down = kinematics.objective(back, reference, targets);
            CHECK(up > value);
            CHECK(down > value);
            CHECK(std::abs(up - down) / (2 * h) < 1e-2 * before);
        }
    }
    // Another start ends in the same place.
    Rotations other = reference;
    for (const int j : free) other[j] = rotation_of(random_vector(random, 0.05)) * other[j];
    kinematics.solve(reference, targets, other);
    for (const int j : free) CHECK(rotation_angle(other[j], world[j]) < 1e-5);
}

TEST_CASE("reachable targets are reached and unreachable ones pointed at")
{
    Random random(4, "kinematics");
    const Points rest = human_joints();
    const std::vector<int> free = joints(free_names), goals = joints(goal_names);
    InverseKinematicsOptions options;
    options.rotation_sigma = 100.0;
    const InverseKinematics kinematics(standard_skeleton(), rest, free, goals, options);
    const Rotations truth = random_rotations(random, 0.4, free);
    const Rotations start(num_standard_joints, Eigen::Matrix3d::Identity());
    Rotations world = start;
    kinematics.solve(start, kinematics.positions(truth), world);
    CHECK((kinematics.positions(world) - kinematics.positions(truth)).rowwise().norm().maxCoeff() < 1e-3);
    for (int j = 1; j < num_standard_joints; ++j) {
        if (std::find(free.begin(), free.end(), j) != free.end()) continue;
        CHECK((world[j] - world[standard_skeleton().parents[j]]).norm() == 0.0);
    }

    // The arm alone, ten metres to the left: it is stretched out.
    const InverseKinematics arm(standard_skeleton(), rest, joints({"pelvis", "left_upper_arm", "left_forearm"}),
                                joints({"left_hand", "neck_1", "right_thigh", "left_thigh"}));
    Points far = arm.positions(start);
    far.row(0) = Eigen::RowVector3d(10.0, 0.45, 0.0);
    for (int g = 1; g < 4; ++g) far.row(g) *= 1.0;
    world = start;
    arm.solve(start, far, world);
    const Points reached = arm.positions(world);
    CHECK(reached.allFinite());
    CHECK((far.row(0) - reached.row(0)).norm() < 9.6);
}

TEST_CASE("what is in place stays, and twists are the reference's")
{
    Random random(5, "kinematics");
    const std::vector<int> free = joints(free_names);
    const InverseKinematics kinematics(standard_skeleton(), human_joints(), free, joints(goal_names));
    const Rotations reference = random_rotations(random, 0.8, free);
    Rotations world = reference;
    kinematics.solve(reference, kinematics.positions(reference), world);
    for (const int j : free) CHECK(rotation_angle(world[j], reference[j]) < 1e-9);

    // Started with the forearm twisted about itself, which moves no goal of its own, it comes back.
    const int forearm = standard_skeleton().joint("left_forearm");
    const InverseKinematics wrist(standard_skeleton(), human_joints(),
                                  joints({"pelvis", "left_upper_arm", "left_forearm"}), joints({"left_hand"}));
    Rotations follow = reference;
    for (int j = 1; j < num_standard_joints; ++j) {
        if (j != forearm && j != standard_skeleton().joint("left_upper_arm")) {
            follow[j] = follow[standard_skeleton().parents[j]];
        }
    }
    const Points rest = human_joints();
    const Eigen::Vector3d bone =
        (rest.row(standard_skeleton().joint("left_hand")) - rest.row(forearm)).transpose().normalized();
    world = follow;
    world[forearm] = world[forearm] * rotation_of(0.6 * bone);
    wrist.solve(follow, wrist.positions(follow), world);
    CHECK(rotation_angle(world[forearm], follow[forearm]) < 1e-6);
}
