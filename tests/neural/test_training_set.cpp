// SPDX-License-Identifier: Apache-2.0
// Which samples are learned from, and what the network is shown of them.
#include "ndg/neural/training_set.h"

#include "ndg/core/error.h"
#include "ndg/neural/output_basis.h"
#include "synthetic.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;
using namespace ndg::test;

namespace {

std::vector<float> target_of(const TrainingSet& set, int sample_idx)
{
    std::vector<float> target(set.width());
    set.target(sample_idx, target.data());
    return target;
}

}  // namespace

TEST_CASE("targets kept in memory, of kept operators and computed anew are the same")
{
    const Synthetic s = make_synthetic(8, 2);
    const NeuralModel model = s.model(small_network());
    const TrainingSet kept = s.set("train", model), computed = s.set("train", model, 0.0);
    for (int i = 0; i < kept.size(); ++i) CHECK(target_of(kept, i) == target_of(computed, i));
    CHECK(kept.digest() == computed.digest());
    // Two bodies' operators of 19 doubles a prism fit where forty targets of 9 half numbers a prism do not.
    Synthetic few_bodies = make_synthetic(40, 2);
    for (int i = 0; i < 40; ++i) few_bodies.samples[0].pairs[i].body_idx = i % 2;
    const TrainingSet all = few_bodies.set("train", model);
    for (const double bytes_a_prism : {100.0, 200.0, 400.0, 700.0, 800.0, 1100.0}) {
        const TrainingSet some = few_bodies.set("train", model, 1e-9 * bytes_a_prism * s.tube.num_prisms());
        for (int i = 0; i < 40; ++i) CHECK(target_of(some, i) == target_of(all, i));
        for (int i = 0; i < 40; ++i) CHECK(target_of(some, i) == target_of(all, i));
    }
}

TEST_CASE("targets are those of the output space, rounded to float16 about the neutral prediction")
{
    const Synthetic s = make_synthetic(8, 2);
    const NeuralModel model = s.model(small_network());
    const TrainingSet set = s.set("train", model);
    const std::vector<float> neutral = neutral_prediction(model.output_space());
    const BodyPoser poser(s.tube, test::bending);
    bool rounded = false;
    for (int i = 0; i < set.size(); ++i) {
        const Body& body = s.bodies.bodies[set.pair(i).body_idx];
        const std::vector<float> stored = s.samples[0].coordinates(i);
        std::vector<float> exact(set.width());
        model.output_space().target(poser.pose(body, s.poses.poses[set.pair(i).pose_idx], set.pair(i)),
                                    RestOperators(s.tube.prisms, body.volume_vertices),
                                    Eigen::Map<const PointsF>(stored.data(), stored.size() / 3, 3), exact.data());
        for (int again = 0; again < 2; ++again) {  // made, then read from memory
            const std::vector<float> target = target_of(set, i);
            for (int k = 0; k < set.width(); ++k) {
                CHECK(std::abs(target[k] - exact[k]) <= std::abs(exact[k] - neutral[k]) / 2048 + 1e-7);
                rounded = rounded || target[k] != exact[k];
            }
        }
    }
    CHECK(rounded);
}

TEST_CASE("only converged simulations of the split are used")
{
    Synthetic s = make_synthetic(8, 2);
    const NeuralModel model = s.model(small_network());
    const std::string whole = s.set("train", model).digest();
    s.samples[0].statistics["converged"][3] = 0.0;
    const TrainingSet training = s.set("train", model), validation = s.set("validation", model);
    CHECK(training.size() == 7);
    CHECK(training.num_unconverged() == 1);
    CHECK(training.pair(3).pose_idx == 4);
    CHECK(validation.size() == 2);
    CHECK(training.digest() != whole);
}

TEST_CASE("samples that do not fit are refused")
{
    const Synthetic good = make_synthetic(4, 2);
    const NeuralModel model = good.model(small_network());
    Synthetic s = good;
    CHECK_THROWS_AS(s.set("test", model), InputError);
    s.samples.push_back(s.samples[0]);
    CHECK_THROWS_WITH(s.set("train", model), Catch::Contains("twice"));
    s = good;
    s.samples[0].pairs[1].body_idx = 8;
    CHECK_THROWS_WITH(s.set("train", model), Catch::Contains("body 8"));
    s = good;
    s.samples[0].pairs[1].pose_idx = 6;
    CHECK_THROWS_WITH(s.set("train", model), Catch::Contains("pose 6"));
    s = good;
    s.samples[0].pairs[1].num_frames = 2;
    CHECK_THROWS_AS(s.set("train", model), InputError);
    s = good;
    s.samples[0].num_volume_vertices -= 1;
    CHECK_THROWS_AS(s.set("train", model), InputError);
    s = good;
    s.samples[0].posing.bone_wrap = BoneWrap::rigid;
    CHECK_THROWS_WITH(s.set("train", model), Catch::Contains("bone-wrap rigid"));
}

TEST_CASE("inputs see the joints that move the volume, and the body")
{
    const Synthetic s = make_synthetic(4, 2);
    const InputSpace space(s.tube, s.shape_space, true), without_shape(s.tube, s.shape_space, false);
    const auto index = [](const char* name) { return standard_skeleton().joint(name); };
    const std::vector<int>& visible = space.visible_joints();
    CHECK(visible[index("left_upper_arm")] == 1);
    CHECK(visible[index("left_forearm")] == 1);
    CHECK(visible[index("left_clavicle")] == 1);  // turns the arm
    CHECK(visible[index("left_hand")] == 0);
    CHECK(visible[index("right_thigh")] == 0);
    CHECK(visible[0] == 0);

    Pose pose = arm_pose(0.4, 0.1, 0.2);
    const Eigen::VectorXd code = space.encode(s.bodies.bodies[1]);
    const Eigen::RowVectorXf features = space.features({code, pose});
    REQUIRE(space.width() == 540 + 2);
    REQUIRE(features.size() == 540 + 2);
    const int forearm = 9 * index("left_forearm");
    const Eigen::Matrix3d& elbow = pose.parent_from_joint[index("left_forearm")];
    CHECK(features[forearm] == Approx(elbow(0, 0) - 1.0));
    CHECK(features[forearm + 1] == Approx(elbow(0, 1)));
    CHECK(features[forearm + 3] == Approx(elbow(1, 0)));
    // One scale for all: what hardly varies stays small.
    CHECK(features[540] == Approx(code[0] / s.shape_space.standard_deviations[0]));
    CHECK(features[541] == Approx(code[1] / s.shape_space.standard_deviations[0]));
    pose.parent_from_joint[0] = rotation_about({1, 1, 1}, 1.0);
    pose.parent_from_joint[index("left_hand")] = rotation_about({1, 0, 0}, 1.0);
    CHECK(space.features({code, pose}) == features);
    CHECK(without_shape.features({code, pose}).size() == 540);
    CHECK_THROWS_AS(space.features({code.head(1), tube_pose(0)}), InputError);
    pose.parent_from_joint.pop_back();
    CHECK_THROWS_AS(space.features({code, pose}), InputError);
}

TEST_CASE("the output basis spans the outputs that the training samples ask for")
{
    const Synthetic s = make_synthetic(12, 2);
    NetworkOptions options = small_network();
    options.parametrisation = ParametrisationKind::direct;
    options.output_basis = 100;
    const NeuralModel model = s.model(options);
    const TrainingSet set = s.set("train", model);
    const RowMatrixF basis = fit_output_bases(set, nullptr, model.output_space(), {}, options, 1).front();
    REQUIRE(basis.rows() <= 12);
    const Eigen::MatrixXd gram = (basis * basis.transpose()).cast<double>();
    CHECK((gram - Eigen::MatrixXd(gram.diagonal().asDiagonal())).norm() < 1e-3 * gram.norm());
    const std::vector<float> target = target_of(set, 5);
    Eigen::RowVectorXf outputs(set.width());
    model.output_space().approximate_inverse(target.data(), outputs.data());
    const Eigen::RowVectorXd wanted = outputs.cast<double>();
    const Eigen::RowVectorXd coefficients =
        (wanted * basis.transpose().cast<double>()).cwiseQuotient(gram.diagonal().transpose());
    CHECK((coefficients * basis.cast<double>() - wanted).norm() < 1e-3 * wanted.norm());
    options.output_basis = 3;
    CHECK(fit_output_bases(set, nullptr, model.output_space(), {}, options, 1).front().rows() == 3);
}

TEST_CASE("a training set can be the first samples of its split")
{
    const Synthetic s = make_synthetic();
    const NeuralModel model = s.model(small_network());
    const TrainingSet whole = s.set("train", model), few = s.set("train", model, 1.0, 7);
    REQUIRE(few.size() == 7);
    REQUIRE(whole.size() > 7);
    CHECK(few.features() == whole.features().topRows(7));
    for (int i = 0; i < 7; ++i) CHECK(few.pair(i) == whole.pair(i));
    CHECK(few.digest() != whole.digest());
    CHECK_THROWS_WITH(s.set("train", model, 1.0, whole.size() + 1), Catch::Contains("were asked for, there are"));
}
