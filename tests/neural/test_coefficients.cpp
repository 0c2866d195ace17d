// SPDX-License-Identifier: Apache-2.0
// Coefficients found once against projections of changed targets, and their loss against that of predictions.
#include "ndg/neural/coefficients.h"
#include "ndg/neural/model_state.h"
#include "ndg/neural/objective.h"
#include "ndg/neural/output_basis.h"
#include "synthetic.h"

// libtorch's logging macros share names with Catch2.
#undef CHECK
#include <catch2/catch.hpp>

using namespace ndg;
using namespace ndg::test;
using torch::Tensor;

namespace {

/// Poses of both arms of three bodies; nothing about them is symmetric.
Synthetic asymmetric_samples(int count)
{
    Synthetic s = two_sided_tube();
    std::vector<Body> bodies;
    for (int i = 0; i < 3; ++i) bodies.push_back(scaled_tube(s.tube, 1 + 0.1 * i, 1 - 0.05 * i));
    s.bodies.bodies = bodies;
    s.shape_space = fit_shape_space({&s.bodies.bodies[0].volume_vertices, &s.bodies.bodies[1].volume_vertices}, 1, 1.0);
    DeformationSet set = no_samples(s.tube);
    Random random(4, "coefficients");
    for (int i = 0; i < count; ++i) {
        const Pose pose = two_arm_pose(random);
        s.poses.poses.push_back(pose);
        Body sheared = s.bodies.bodies[i % 3];
        for (Eigen::Index v = s.tube.num_wrap_vertices(); v < sheared.volume_vertices.rows(); ++v)
            sheared.volume_vertices(v, 2) += 0.2 * random.normal() * std::max(0.0, sheared.volume_vertices(v, 0));
        set.add({i % 3, i}, "train", bulged_tube(s.tube, sheared, pose));
    }
    s.samples = {set};
    return s;
}

NetworkOptions fixed_basis(const std::string& output_space, int region_reach)
{
    NetworkOptions options = small_network();
    options.output_space = output_space;
    options.parametrisation = ParametrisationKind::direct;
    options.output_basis = 8;
    options.region_reach = region_reach;
    return options;
}

}  // namespace

TEST_CASE("coefficients of changed samples are those of their changed targets, and losses the same")
{
    const Synthetic s = asymmetric_samples(18);
    for (const char* output_space : {"residuals", "vertex-offsets"})
        for (const int region_reach : {0, 2}) {
            CAPTURE(output_space, region_reach);
            const NetworkOptions options = fixed_basis(output_space, region_reach);
            NeuralModel model = s.model(options);
            const TrainingSet set = s.set("train", model);
            const OutputSpace& space = model.output_space();
            AugmentationOptions changes;
            changes.mirror = true;
            changes.splice = 0.5;
            const Augmentation augmentation(set, model.input_space(), space, changes, 1);
            const Network network = model.state().new_network(
                fit_output_bases(set, &augmentation, space, model.state().columns, options, 1));
            const Coefficients coefficients(set, &augmentation, space, network);

            // Zero and unit coefficients through the network's own forward: its bases as a matrix.
            RowMatrixF basis = RowMatrixF::Zero(coefficients.width(), space.width());
            Eigen::Index row = 0;
            for (const Network::Part& part : network.parts) {
                const RowMatrixF own = TorchNetwork::matrix(part.perceptron.basis);
                for (Eigen::Index k = 0; k < own.cols(); ++k)
                    basis.col(part.outputs.defined() ? part.outputs[k].item<int>() : k).segment(row, own.rows()) =
                        own.col(k);
                row += own.rows();
            }
            const std::vector<float> neutral = neutral_prediction(space);
            SampleChange changes_of[4];
            changes_of[1].mirrored = true;
            changes_of[2].other_idx = 6;
            changes_of[2].from_other = 0b001110;
            changes_of[3] = changes_of[2];
            changes_of[3].mirrored = true;
            Eigen::RowVectorXf first;
            for (const SampleChange& change : changes_of) {
                Eigen::RowVectorXf target(space.width()), found(coefficients.width());
                augmentation.target(3, change, target.data());
                coefficients.of_sample(3, change, found.data());
                const Eigen::VectorXd beyond =
                    (target - Eigen::Map<const Eigen::RowVectorXf>(neutral.data(), target.size()))
                        .cast<double>()
                        .transpose();
                const Eigen::VectorXd expected =
                    (basis.cast<double>() * beyond).cwiseQuotient(coefficients.squared_norms());
                CHECK((found.transpose().cast<double>() - expected).cwiseAbs().maxCoeff() <
                      2e-3 * expected.cwiseAbs().maxCoeff());
                if (first.size() > 0)
                    CHECK((found - first).norm() > 0.05 * first.norm());
                else
                    first = found;
            }
            const auto by_coefficients = make_objective(set, nullptr, space, network, Device::cpu);
            REQUIRE(by_coefficients->last_layer() == LastLayer::coefficients);
            double loss = 0, neutral_loss = 0, expected_loss = 0, expected_neutral = 0;
            torch::manual_seed(1);
            for (int i = 0; i < set.size(); ++i) {
                const Tensor given = torch::randn({1, coefficients.width()});
                Tensor target = torch::empty({1, coefficients.width()}), full = torch::empty({1, space.width()});
                by_coefficients->target(i, {}, target.data_ptr<float>());
                set.target(i, full.data_ptr<float>());
                loss += by_coefficients->loss(given, target).item<double>();
                neutral_loss += by_coefficients->neutral_loss(target);
                const auto mean_square = [&](const Tensor& weights) {
                    return torch::mse_loss(space.activate(torch::mm(weights, tensor_from(basis))), full).item<double>();
                };
                expected_loss += mean_square(given);
                expected_neutral += mean_square(torch::zeros_like(given));
            }
            CHECK(loss == Approx(expected_loss).epsilon(1e-3));
            CHECK(neutral_loss == Approx(expected_neutral).epsilon(1e-3));
        }
}

TEST_CASE("what is not linear, or has no fixed basis, is compared as predictions")
{
    const Synthetic s = asymmetric_samples(6);
    NetworkOptions options = fixed_basis("residuals", 0);
    options.parametrisation = ParametrisationKind::exponential;
    NeuralModel exponential = s.model(options);
    const TrainingSet set = s.set("train", exponential);
    CHECK(make_objective(set, nullptr, exponential.output_space(), exponential.state().network, Device::cpu)
              ->last_layer() == LastLayer::outputs);
    options = fixed_basis("residuals", 0);
    options.output_basis = 0;
    NeuralModel trained_layer = s.model(options);
    CHECK(make_objective(set, nullptr, trained_layer.output_space(), trained_layer.state().network, Device::cpu)
              ->last_layer() == LastLayer::outputs);
}
