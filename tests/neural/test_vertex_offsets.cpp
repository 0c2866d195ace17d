// SPDX-License-Identifier: Apache-2.0
// VertexNet: offsets undo linear blend skinning, and its decoder loses nothing that it could hold.
#include "ndg/neural/vertex_offsets.h"

#include "ndg/core/error.h"
#include "ndg/neural/output_basis.h"
#include "synthetic.h"

#include <catch2/catch.hpp>

#include <Eigen/Cholesky>

using namespace ndg;
using namespace ndg::test;

namespace {

NetworkOptions vertexnet(int output_basis = 0)
{
    NetworkOptions options = small_network();
    options.output_space = "vertex-offsets";
    options.output_basis = output_basis;
    return options;
}

std::vector<float> target_of(const OutputSpace& space, const PosedBody& posed, const Points& vertices)
{
    RestCache rest(posed.body_template());
    std::vector<float> target(space.width());
    space.target(posed, rest.operators(posed.body()), vertices.cast<float>(), target.data());
    return target;
}

}  // namespace

TEST_CASE("offsets are those of the rest pose, in mm")
{
    const Synthetic s = make_synthetic(8, 2);
    const BodyPoser poser(s.tube, test::bending);
    const Body& body = s.bodies.bodies[2];
    Pose pose = arm_pose(0.9, 0.3, -0.4);
    pose.parent_from_joint[0] = rotation_about({1, 2, -0.5}, 2.2);
    pose.root_translation << 0.3, -0.2, 1;
    Body changed = body;
    changed.volume_vertices.bottomRows(2 * s.tube.num_wrap_vertices()).array().col(1) += 0.007;
    const Points vertices = poser.pose(changed, pose).skinned_volume();
    const auto space = make_output_space(s.tube, vertexnet());
    const std::vector<float> target = target_of(*space, poser.pose(body, pose), vertices);
    REQUIRE(target.size() == static_cast<std::size_t>(6 * s.tube.num_wrap_vertices()));
    for (std::size_t k = 0; k < target.size(); ++k) REQUIRE(target[k] == Approx(k % 3 == 1 ? 7.0 : 0.0).margin(2e-3));
}

TEST_CASE("vertices of a deformation's own offsets are the deformation")
{
    const Synthetic s = make_synthetic(8, 2);
    const BodyPoser poser(s.tube, test::bending);
    RestCache rest(s.tube);
    const PosedBody posed = poser.pose(s.bodies.bodies[3], arm_pose(1.4, -0.5, 0.5));
    const Points deformed = bulged_tube(s.tube, posed.body(), posed.pose());
    const auto space = make_output_space(s.tube, vertexnet());
    const std::vector<float> target = target_of(*space, posed, deformed);
    CHECK((space->vertices(posed, rest, target.data()) - deformed).cwiseAbs().maxCoeff() < 1e-6);
    CHECK((posed.skinned_volume() - deformed).cwiseAbs().maxCoeff() > 1e-2);
    // No offsets: linear blend skinning.
    const std::vector<float> neutral = neutral_prediction(*space);
    CHECK((space->vertices(posed, rest, neutral.data()) - posed.skinned_volume()).norm() < 1e-12);
    CHECK_THROWS_WITH(space->gradients(posed, target.data()), Catch::Contains("no deformation gradients"));
}

TEST_CASE("a full basis reproduces every training sample")
{
    const Synthetic s = make_synthetic(20, 2);
    const BodyPoser poser(s.tube, test::bending);
    const NeuralModel model = s.model(vertexnet());
    const TrainingSet set = s.set("train", model);
    const RowMatrixF basis = fit_output_bases(set, nullptr, model.output_space(), {}, vertexnet(680), 1).front();
    REQUIRE(basis.rows() <= 20);
    const Eigen::MatrixXd axes = basis.cast<double>();
    const Eigen::MatrixXd gram = axes * axes.transpose();
    for (int i = 0; i < set.size(); ++i) {
        Eigen::RowVectorXf target(set.width());
        set.target(i, target.data());
        const Eigen::VectorXd coefficients = gram.ldlt().solve(axes * target.cast<double>().transpose());
        const Eigen::RowVectorXf decoded = (coefficients.transpose() * axes).cast<float>();
        const Points deformed = s.samples[0].points(i);
        RestCache rest(s.tube);
        const PosedBody posed = poser.pose(set.body(i), set.pose(i));
        REQUIRE((decoded - target).cwiseAbs().maxCoeff() < 2e-3);
        // Training sets round targets to float16.
        const double rounding = 1e-3 * target.cwiseAbs().maxCoeff() / 2048 * std::sqrt(3.0);
        REQUIRE((model.output_space().vertices(posed, rest, decoded.data()) - deformed).cwiseAbs().maxCoeff() <
                2e-6 + rounding);
    }
    // Fewer where the rest is not asked for.
    NetworkOptions few = vertexnet(680);
    few.output_basis_variance = 0.5;
    const Eigen::Index count = fit_output_bases(set, nullptr, model.output_space(), {}, few, 1).front().rows();
    CHECK(count >= 1);
    CHECK(count < basis.rows());
}

TEST_CASE("a vertex network learns the rule through its decoder")
{
    const Synthetic s = make_synthetic();
    NeuralModel model = s.model(vertexnet(40));
    TrainingOptions training;
    training.epochs = 80;
    training.learning_rate = 5e-3;
    training.schedule = Schedule::cosine;
    train(model, s.set("train", model), s.set("validation", model), training);
    const TrainingCurve& curve = model.curve();
    CHECK(curve.validation_loss[curve.best_epoch - 1] < 0.05 * curve.initial_validation_loss);
    CHECK(method_name(model.options()) == "VertexNet");
}
