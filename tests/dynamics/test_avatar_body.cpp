// SPDX-License-Identifier: Apache-2.0
// An avatar as a body that a motion drives.
#include "tube_avatar.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/dynamics/avatar_body.h"
#include "ndg/dynamics/motion_simulation.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;

TEST_CASE("An avatar's soft tissue follows its own skinning and comes to rest in its skinned shape")
{
    const Template tube = test::tube_template(7, 8);
    Avatar avatar = test::tube_avatar(tube);
    avatar.pose_joints = {tube.skeleton.joint("left_forearm")};
    avatar.pose_directions = RowMatrixF::Zero(9, avatar.rest.size());
    for (Eigen::Index k = 0; k < avatar.rest.size(); ++k) {
        avatar.pose_directions(0, k) = 0.01f * std::sin(static_cast<float>(k));
    }

    const SoftBody tissue = soft_body_of(avatar, TissueStiffness{{8e3}, {15e3}});
    REQUIRE_NOTHROW(tissue.check());
    REQUIRE(tissue.young_normal_pascal[5] == 8e3);
    REQUIRE(tissue.young_tangent_pascal[5] == 15e3);
    SoftTissueBody body(tissue, poser_of(avatar), {}, 1000);
    REQUIRE(body.joint_positions() == avatar.joint_positions);
    const Pose bent = test::tube_pose(0.9);
    const Points skinned = to_world(AvatarPoser(avatar).world_from_unposed(bent), avatar.rest);
    REQUIRE((body.equilibrium(bent) - skinned).norm() < 1e-14);
    REQUIRE((skinned - apply_maps(test::tube_poser(tube).world_from_unposed(bent), avatar.rest)).norm() > 1e-3);

    std::vector<Pose> poses;
    for (int n = 0; n <= 24; ++n) poses.push_back(test::tube_pose(0.9 * n / 24));
    DynamicsOptions options;
    options.newton = {1e-10, 1e-10, 100};
    options.hold_seconds = 1.5;
    options.frames_per_block = 1000;
    MotionSimulation simulation(body, poses, {}, options);
    const DynamicBlock block = simulation.run(0, std::nullopt);
    REQUIRE((block.state.positions - skinned).rowwise().norm().maxCoeff() < 1e-6);
    // On the way it was elsewhere.
    const std::vector<float>& at_stop = block.vertices[6];
    const Points early = Eigen::Map<const RowMatrixF>(at_stop.data(), avatar.rest.rows(), 3).cast<double>();
    REQUIRE((early - skinned).rowwise().norm().maxCoeff() > 1e-3);
}

TEST_CASE("Moduli at an avatar's control points are carried to its vertices as the avatar says")
{
    Avatar avatar;
    avatar.name = "two points";
    avatar.rest = Points::Zero(3, 3);
    avatar.control_weights = (RowMatrix(3, 2) << 1, 0, 0, 1, 0.25, 0.75).finished();
    const SoftBody body = soft_body_of(avatar, {{4e3, 8e3}, {10e3}});
    REQUIRE(body.young_normal_pascal.isApprox(Eigen::Vector3d(4e3, 8e3, 7e3)));
    REQUIRE(body.young_tangent_pascal.isApprox(Eigen::Vector3d::Constant(10e3)));
    REQUIRE_THROWS_WITH(soft_body_of(avatar, {{1e3, 2e3, 3e3}, {1e3}}), Catch::Contains("3 moduli for the 2 control"));

    const test::TemporaryFolder folder;
    const std::string path = folder.file("stiffness.json");
    TissueStiffness stiffness;
    write_file(path, R"({"young_normal_pascal": [5000, 6000]})");
    read_stiffness(path, avatar, stiffness);
    REQUIRE(stiffness.young_normal_pascal == std::vector<double>{5000, 6000});
    REQUIRE(stiffness.young_tangent_pascal == std::vector<double>{15e3});
    write_file(path, R"({"young_tangent_pascal": 9000})");
    read_stiffness(path, avatar, stiffness);
    REQUIRE(stiffness.young_tangent_pascal == std::vector<double>{9000});
    for (const char* bad : {R"({"young_normal_pascal": [5000]})", R"({"young_normal_pascal": [5000, -1]})",
                            R"({"young_modulus": 5000})", R"({"young_tangent_pascal": "soft"})"}) {
        write_file(path, bad);
        INFO(bad);
        REQUIRE_THROWS_AS(read_stiffness(path, avatar, stiffness), InputError);
    }
}
