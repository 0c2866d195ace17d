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

std::vector<PoseInput> some_inputs(const Synthetic& s, const NeuralModel& model)
{
    return {s.input(model, 1, 1), s.input(model, 6, 6), s.input(model, 7, 7)};
}

double largest_difference(const RowMatrixF& a, const RowMatrixF& b)
{
    return static_cast<double>((a - b).cwiseAbs().maxCoeff());
}

}  // namespace

TEST_CASE("without shape the body is not seen, with shape it is")
{
    const Synthetic s = make_synthetic(24, 8);
    for (const bool shape : {true, false}) {
        NetworkOptions options = small_network();
        options.shape = shape;
        const NeuralModel model = moved_model(s, options);
        const Pose pose = arm_pose(1.0, 0, 0);
        const auto thin = model.predict({{model.input_space().encode(s.bodies.bodies[0]), pose}});
        const auto thick = model.predict({{model.input_space().encode(s.bodies.bodies[1]), pose}});
        CHECK((largest_difference(thin, thick) > 1e-4) == shape);
    }
}

TEST_CASE("a sample's prediction does not depend on the batch beyond rounding")
{
    const Synthetic s = make_synthetic(40, 8);
    const NeuralModel model = moved_model(s, small_network());
    std::vector<PoseInput> inputs;
    for (int i = 0; i < 40; ++i) inputs.push_back(s.input(model, i % 8, i));
    const RowMatrixF together = model.predict(inputs);
    REQUIRE(together.rows() == 40);
    for (int i = 0; i < 40; ++i) CHECK(largest_difference(together.row(i), model.predict({inputs[i]})) < 1e-5);
    CHECK(model.predict({}).rows() == 0);
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
        const NeuralModel model = moved_model(s, options);
        const std::string path = folder.file(fmt::format("model_{}.h5", output_basis));
        model.save(path, provenance);
        const NeuralModel loaded = NeuralModel::load(path, s.tube);
        CHECK(largest_difference(model.predict(some_inputs(s, model)), loaded.predict(some_inputs(s, loaded))) == 0.0);
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
    const NeuralModel model = s.model(small_network());
    const std::string path = folder.file("model.h5");
    model.save(path, provenance);
    Template longer = tube_template(6, 6);
    CHECK_THROWS_WITH(NeuralModel::load(path, longer), Catch::Contains("another template"));
    longer.file_sha256 = "tube";
    CHECK_THROWS_WITH(NeuralModel::load(path, longer), Catch::Contains("/shape_space/components"));
    Template renamed = s.tube;
    renamed.skeleton.joint_names[4] = "elbow";
    CHECK_THROWS_WITH(NeuralModel::load(path, renamed), Catch::Contains("elbow"));
    CHECK_THROWS_AS(NeuralModel::load(folder.file("missing.h5"), s.tube), InputError);
    const std::string truncated = folder.file("truncated.h5");
    std::filesystem::copy_file(path, truncated);
    std::filesystem::resize_file(truncated, std::filesystem::file_size(path) / 2);
    CHECK_THROWS_AS(NeuralModel::load(truncated, s.tube), InputError);
    ShapeSpace other_space = s.shape_space;
    other_space.mean.conservativeResize(other_space.mean.size() - 3);
    CHECK_THROWS_AS(NeuralModel(small_network(), other_space, s.tube, 1), InputError);
}

TEST_CASE("a model is named by what it is")
{
    NetworkOptions options;
    CHECK(method_name(options) == "NDG");
    options.parametrisation = ParametrisationKind::direct;
    CHECK(method_name(options) == "NDG no matrix exp");
    options.output_basis = 600;
    options.shape = false;
    CHECK(method_name(options) == "NDG fixed basis, no matrix exp, no body shape");
    options = {};
    options.rotation = false;
    CHECK(method_name(options) == "NDG no rotation");
    options.output_space = "vertex-offsets";
    options.output_basis = 680;
    CHECK(method_name(options) == "VertexNet");
}

TEST_CASE("options that make no sense are refused")
{
    NetworkOptions network;
    CHECK_NOTHROW(network.check());
    network.widths = {64, 0};
    CHECK_THROWS_AS(network.check(), InputError);
    network = {};
    const Synthetic s = make_synthetic(8, 2);
    network.parametrisation = ParametrisationKind::lu;
    network.output_basis = 4;
    CHECK_THROWS_WITH(s.model(network), Catch::Contains("output_basis"));
    network = {};
    network.output_space = "colours";
    CHECK_THROWS_WITH(s.model(network), Catch::Contains("colours"));
    TrainingOptions training;
    CHECK_NOTHROW(check_options(training));
    CHECK(test::undescribed_bytes<NetworkOptions>().empty());
    CHECK(test::undescribed_bytes<TrainingOptions>().empty());
    training.learning_rate = std::nan("");
    CHECK_THROWS_AS(check_options(training), InputError);
}
