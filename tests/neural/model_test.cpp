// SPDX-License-Identifier: Apache-2.0
// The model: what it starts as, its invariances, its file.
#include "ndg/neural/model.h"

#include "ndg/core/error.h"
#include "ndg/neural/train.h"
#include "support/described.h"
#include "synthetic.h"

#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>

using namespace ndg;
using namespace ndg::test;

namespace {

std::vector<PoseInput> some_inputs(const Synthetic& s, const NdgModel& model)
{
    std::vector<PoseInput> inputs;
    for (const int i : {1, 6, 7})
        inputs.push_back(
            {model.encode(s.bodies.bodies[static_cast<std::size_t>(i)]), s.poses.poses[static_cast<std::size_t>(i)]});
    return inputs;
}

/// A model a few quick steps away from its start, so that nothing about it is trivial.
NdgModel moved_model(const Synthetic& s, const NetworkOptions& options)
{
    NdgModel model(options, s.shape_space, s.tube, "tube", 5);
    TrainingOptions training;
    training.epochs = 3;
    training.learning_rate = 0.02;
    train(model, s.set("train", options), s.set("validation", options), training);
    return model;
}

double largest_difference(const std::vector<GradientsF>& a, const std::vector<GradientsF>& b)
{
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        largest = std::max(largest, static_cast<double>((a[i] - b[i]).cwiseAbs().maxCoeff()));
    return largest;
}

double smallest_determinant(const std::vector<GradientsF>& all)
{
    double smallest = 1e30;
    for (const GradientsF& gradients : all)
        for (Eigen::Index p = 0; p < gradients.rows(); ++p) {
            const Eigen::Matrix<float, 3, 3, Eigen::RowMajor> f =
                Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(gradients.row(p).data());
            smallest = std::min(smallest, static_cast<double>(f.determinant()));
        }
    return smallest;
}

}  // namespace

TEST_CASE("an untrained model is gradient skinning, exactly")
{
    const Synthetic s = make_synthetic(8, 2);
    for (const std::string& parametrisation : names<ParametrisationKind>()) {
        CAPTURE(parametrisation);
        NetworkOptions options = small_network();
        options.parametrisation = parse_name<ParametrisationKind>(parametrisation);
        const NdgModel model(options, s.shape_space, s.tube, "tube", 1);
        const std::vector<PoseInput> inputs = some_inputs(s, model);
        const std::vector<GradientsF> gradients = model.predict_gradients(inputs);
        REQUIRE(gradients.size() == inputs.size());
        for (std::size_t i = 0; i < inputs.size(); ++i) {
            const auto rotations =
                blend_rotations(s.tube.prism_weights(),
                                forward_kinematics(s.tube.skeleton, s.tube.rest.joint_positions, inputs[i].pose));
            REQUIRE(gradients[i].rows() == s.tube.num_prisms());
            for (Eigen::Index p = 0; p < gradients[i].rows(); ++p)
                for (int k = 0; k < 9; ++k)
                    REQUIRE(gradients[i](p, k) ==
                            Approx(rotations[static_cast<std::size_t>(p)](k / 3, k % 3)).margin(1e-7));
        }
    }
}

TEST_CASE("predictions turn with the root")
{
    const Synthetic s = make_synthetic(24, 8);
    for (const bool rotation : {true, false}) {
        NetworkOptions options = small_network();
        options.rotation = rotation;
        const NdgModel model = moved_model(s, options);
        std::vector<PoseInput> inputs = some_inputs(s, model);
        const std::vector<GradientsF> before = model.predict_gradients(inputs);
        const Eigen::Matrix3d turn = rotation_about({1, -2, 0.7}, 2.5);
        for (PoseInput& input : inputs) input.pose.parent_from_joint[0] = turn * input.pose.parent_from_joint[0];
        const std::vector<GradientsF> after = model.predict_gradients(inputs);
        double largest = 0;
        for (std::size_t i = 0; i < before.size(); ++i)
            for (Eigen::Index p = 0; p < before[i].rows(); ++p) {
                using RowMatrix3f = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;
                const RowMatrix3f f = Eigen::Map<const RowMatrix3f>(before[i].row(p).data());
                const RowMatrix3f g = Eigen::Map<const RowMatrix3f>(after[i].row(p).data());
                largest = std::max(largest, static_cast<double>((g - turn.cast<float>() * f).cwiseAbs().maxCoeff()));
            }
        CHECK(largest < 5e-6);
    }
}

TEST_CASE("predicted determinants are positive whatever the weights")
{
    const Synthetic s = make_synthetic(24, 8);
    for (const char* parametrisation : {"exponential", "lu", "qr"}) {
        CAPTURE(parametrisation);
        NetworkOptions options = small_network();
        options.parametrisation = parse_name<ParametrisationKind>(parametrisation);
        const NdgModel model = moved_model(s, options);
        std::vector<PoseInput> inputs;
        for (int i = 0; i < 20; ++i)  // far outside of the training poses and bodies
            inputs.push_back({8.0 * model.encode(s.bodies.bodies[static_cast<std::size_t>(i % 8)]),
                              arm_pose(0.3 * i - 3, 0.5 * i, 1.0 - 0.2 * i)});
        const std::vector<GradientsF> residuals = model.predict_residuals(inputs);
        CHECK(smallest_determinant(residuals) > 0);
        CHECK(smallest_determinant(residuals) < 0.99);  // the network has moved at all
        CHECK(smallest_determinant(model.predict_gradients(inputs)) > 0);
    }
}

TEST_CASE("without shape the body is not seen, with shape it is")
{
    const Synthetic s = make_synthetic(24, 8);
    for (const bool shape : {true, false}) {
        NetworkOptions options = small_network();
        options.shape = shape;
        const NdgModel model = moved_model(s, options);
        const Pose pose = arm_pose(1.0, 0, 0);
        const auto thin = model.predict_residuals({{model.encode(s.bodies.bodies[0]), pose}});
        const auto thick = model.predict_residuals({{model.encode(s.bodies.bodies[1]), pose}});
        CHECK((largest_difference(thin, thick) > 1e-4) == shape);
    }
}

TEST_CASE("a sample's prediction does not depend on the batch beyond rounding")
{
    const Synthetic s = make_synthetic(40, 8);
    const NdgModel model = moved_model(s, small_network());
    std::vector<PoseInput> inputs;
    for (std::size_t i = 0; i < 40; ++i) inputs.push_back({model.encode(s.bodies.bodies[i % 8]), s.poses.poses[i]});
    const std::vector<GradientsF> together = model.predict_residuals(inputs);
    REQUIRE(together.size() == 40);
    std::vector<GradientsF> alone;
    for (const PoseInput& input : inputs) alone.push_back(model.predict_residuals({input}).front());
    CHECK(largest_difference(together, alone) < 1e-5);
    CHECK(model.predict_residuals({}).empty());
}

TEST_CASE("a saved model predicts the same, bit for bit")
{
    const TemporaryFolder folder;
    const Synthetic s = make_synthetic(24, 8);
    Provenance provenance;
    provenance.tool = "test";
    for (const int output_basis : {0, 5}) {
        NetworkOptions options = small_network();
        options.output_basis = output_basis;
        options.shape = output_basis == 0;
        const NdgModel model = moved_model(s, options);
        const std::string path = folder.file(fmt::format("model_{}.h5", output_basis));
        model.save(path, provenance);
        const NdgModel loaded = NdgModel::load(path, s.tube, "tube");
        CHECK(largest_difference(model.predict_gradients(some_inputs(s, model)),
                                 loaded.predict_gradients(some_inputs(s, loaded))) == 0.0);
        CHECK(loaded.options().widths == options.widths);
        CHECK(loaded.options().shape == options.shape);
        CHECK(loaded.num_parameters() == model.num_parameters());
        CHECK(loaded.curve().epoch == std::vector<int>{1, 2, 3});
        CHECK(loaded.curve().validation_loss == model.curve().validation_loss);
        CHECK(loaded.curve().best_epoch == model.curve().best_epoch);
        CHECK(loaded.curve().initial_train_loss == model.curve().initial_train_loss);
    }
}

TEST_CASE("a model of another template or a damaged file is refused")
{
    const TemporaryFolder folder;
    const Synthetic s = make_synthetic(8, 2);
    Provenance provenance;
    provenance.tool = "test";
    const NdgModel model(small_network(), s.shape_space, s.tube, "tube", 1);
    const std::string path = folder.file("model.h5");
    model.save(path, provenance);
    CHECK_THROWS_WITH(NdgModel::load(path, s.tube, "other"), Catch::Contains("another template"));
    const Template longer = tube_template(6, 6);
    CHECK_THROWS_WITH(NdgModel::load(path, longer, "tube"), Catch::Contains("prisms"));
    Template renamed = s.tube;
    renamed.skeleton.joint_names[4] = "elbow";
    CHECK_THROWS_WITH(NdgModel::load(path, renamed, "tube"), Catch::Contains("elbow"));
    CHECK_THROWS_AS(NdgModel::load(folder.file("missing.h5"), s.tube, "tube"), InputError);
    const std::string truncated = folder.file("truncated.h5");
    std::filesystem::copy_file(path, truncated);
    std::filesystem::resize_file(truncated, std::filesystem::file_size(path) / 2);
    CHECK_THROWS_AS(NdgModel::load(truncated, s.tube, "tube"), InputError);
    ShapeSpace other_space = s.shape_space;
    other_space.mean.conservativeResize(other_space.mean.size() - 3);
    CHECK_THROWS_AS(NdgModel(small_network(), other_space, s.tube, "tube", 1), InputError);
}

TEST_CASE("options that make no sense are refused")
{
    NetworkOptions network;
    CHECK_NOTHROW(network.check());
    network.widths = {64, 0};
    CHECK_THROWS_AS(network.check(), InputError);
    network = {};
    network.parametrisation = ParametrisationKind::lu;
    network.output_basis = 4;
    CHECK_THROWS_AS(network.check(), InputError);
    TrainingOptions training;
    CHECK_NOTHROW(check_options(training));
    CHECK(undescribed_bytes<NetworkOptions>().empty());
    CHECK(undescribed_bytes<TrainingOptions>().empty());
    training.learning_rate = std::nan("");
    CHECK_THROWS_AS(check_options(training), InputError);
}
