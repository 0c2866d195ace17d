// SPDX-License-Identifier: Apache-2.0
// AMASS on the joints of its body model, against forward kinematics in numpy.
#include "ndg/core/error.h"
#include "ndg/io/motion.h"
#include "ndg/io/smpl_skeleton.h"

#include "io/smpl_model.h"

#include <catch2/catch.hpp>

#include <fstream>

using namespace ndg;
using Catch::Matchers::Contains;

TEST_CASE("joints of AMASS clips are where forward kinematics of the body model has them, fingers and shape included")
{
    const test::TemporaryFolder folder;
    if (!test::write_smpl_model(folder)) return;
    const SmplSkeleton model(folder.file("model.npz")), mean(folder.file("joints.npz"));
    for (const std::string name : {"plain", "shaped"}) {
        INFO(name);
        const MotionClip clip = read_amass(folder.file(name + "_poses.npz"), &model);
        REQUIRE(clip.num_joints() == 52);
        std::ifstream text(folder.file(name + ".txt"));
        double worst = 0.0, worst_of_mean = 0.0, worst_without = 0.0;
        const MotionClip of_mean = read_amass(folder.file(name + "_poses.npz"), &mean);
        const MotionClip without = read_amass(folder.file(name + "_poses.npz"));
        for (int f = 0; f < clip.num_frames(); ++f) {
            Points truth(52, 3);
            for (Eigen::Index i = 0; i < truth.size(); ++i) REQUIRE(text >> truth.data()[i]);
            worst = std::max(worst, (clip.joint_positions(f) - truth).cwiseAbs().maxCoeff());
            worst_of_mean = std::max(worst_of_mean, (of_mean.joint_positions(f) - truth).cwiseAbs().maxCoeff());
            worst_without = std::max(worst_without, (without.joint_positions(f) - truth).cwiseAbs().maxCoeff());
        }
        CHECK(worst < 1e-7);  // the file's shapes are single precision
        if (name == "plain")
            CHECK(worst_of_mean < 1e-7);
        else
            CHECK(worst_of_mean > 0.01);
        CHECK(worst_without > 0.02);
    }
}

TEST_CASE("files that are no body model are refused with what they hold")
{
    const test::TemporaryFolder folder;
    if (!test::write_smpl_model(folder)) return;
    for (const auto& [name, message] : std::initializer_list<std::pair<const char*, const char*>>{
             {"mirrored", "its joints are no person in metres"},
             {"inches", "its joints are no person in metres"},
             {"few", "has 22 joints; SMPL has 24, SMPL-H 52, SMPL-X 55"},
             {"flat", "\"J\" has 2 where 3 are needed"},
             {"other", "\"J_regressor\" has 103 where 104 are needed"},
             {"nothing", "has no array \"J\""}}) {
        const std::string path = folder.file(std::string(name) + ".npz");
        CHECK_THROWS_AS(SmplSkeleton(path), InputError);
        CHECK_THROWS_WITH(SmplSkeleton(path), Contains(path) && Contains(message));
    }
}
