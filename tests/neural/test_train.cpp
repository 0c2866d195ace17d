// SPDX-License-Identifier: Apache-2.0
// Training: it learns, it is reproducible, it resumes.
#include "ndg/neural/train.h"

#include "ndg/core/error.h"
#include "synthetic.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>

using namespace ndg;
using namespace ndg::test;

namespace {

TrainingOptions quick_training(int epochs)
{
    TrainingOptions options;
    options.epochs = epochs;
    options.learning_rate = 5e-3;
    options.schedule = Schedule::cosine;
    options.seed = 11;
    return options;
}

RowMatrixF predictions_of(const Synthetic& s, const NeuralModel& model)
{
    std::vector<PoseInput> inputs;
    for (const SamplePair& pair : s.samples[0].pairs) inputs.push_back(s.input(model, pair.body_idx, pair.pose_idx));
    return model.predict(inputs);
}

/// Trains from the start, or from the checkpoint where there is one.
NeuralModel trained(const Synthetic& s, const NetworkOptions& network, const TrainingOptions& options,
                    const TrainingCallbacks& callbacks = {}, TrainingResult* result = nullptr)
{
    NeuralModel model = s.model(network);
    const TrainingResult got = train(model, s.set("train", model), s.set("validation", model), options, callbacks);
    if (result) *result = got;
    return model;
}

/// Those that the processor can.
std::vector<Precision> precisions()
{
    try {
        resolve_precision(Precision::bfloat16, Device::cpu);
        return {Precision::float32, Precision::bfloat16};
    } catch (const InputError&) {
        return {Precision::float32};
    }
}

/// Five numbers that are linear in what the network sees: two rows of where the upper arm turns to, without the last.
class ArmNumbers : public OutputSpace {
public:
    int width() const override { return 5; }
    Points vertices(const PosedBody& posed, RestCache&, const float*) const override { return posed.skinned_volume(); }
    void target(const PosedBody& posed, const RestOperators&, const Eigen::Ref<const PointsF>&,
                float* target) const override
    {
        const Eigen::Matrix3d& arm = posed.pose().parent_from_joint[standard_skeleton().joint("left_upper_arm")];
        for (int k = 0; k < 5; ++k) target[k] = static_cast<float>(3 * arm(1 + k / 3, k % 3) - k);
    }
};

}  // namespace

TEST_CASE("an output space of one's own is learned like any other")
{
    const Synthetic s = make_synthetic(60, 20);
    NetworkOptions network = small_network();
    for (const int output_basis : {0, 5}) {
        CAPTURE(output_basis);
        network.output_basis = output_basis;
        NeuralModel model(network, s.shape_space, s.tube, std::make_shared<ArmNumbers>(), 5);
        const TrainingSet training = s.set("train", model), validation = s.set("validation", model);
        REQUIRE(training.width() == 5);
        TrainingOptions options = quick_training(150);
        options.batch_size = 10;
        train(model, training, validation, options);
        CHECK(model.curve().validation_loss.back() < 1e-3 * model.curve().initial_validation_loss);
        const RowMatrixF predictions = predictions_of(s, model);
        REQUIRE(predictions.cols() == 5);
        const Eigen::Matrix3d& arm = s.poses.poses[70].parent_from_joint[standard_skeleton().joint("left_upper_arm")];
        CHECK(predictions(70, 4) == Approx(3 * arm(2, 1) - 4).margin(0.2));
        const BodyPoser poser(s.tube, test::bending);
        CHECK_THROWS_WITH(model.output_space().gradients(poser.pose(s.tube.rest, s.poses.poses[0]), predictions.data()),
                          Catch::Contains("no deformation gradients"));
    }
}

TEST_CASE("training learns the rule and carries it to new bodies and poses")
{
    const Synthetic s = make_synthetic();
    NetworkOptions network = small_network();
    for (const int output_basis : {0, 12}) {
        CAPTURE(output_basis);
        network.output_basis = output_basis;
        const NeuralModel model = trained(s, network, quick_training(80));
        const TrainingCurve& curve = model.curve();
        REQUIRE(curve.epoch.size() == 80);
        REQUIRE(curve.best_epoch >= 1);
        const auto best = static_cast<std::size_t>(curve.best_epoch - 1);
        CAPTURE(curve.train_loss[best], curve.validation_loss[best], curve.initial_validation_loss);
        CHECK(curve.train_loss[best] < 0.02 * curve.initial_train_loss);
        CHECK(curve.validation_loss[best] < 0.05 * curve.initial_validation_loss);
        CHECK(*std::min_element(curve.validation_loss.begin(), curve.validation_loss.end()) ==
              curve.validation_loss[best]);
    }
}

TEST_CASE("the curve's loss is that of the predictions")
{
    const Synthetic s = make_synthetic(24, 8);
    const NetworkOptions network = small_network();
    const NeuralModel model = trained(s, network, quick_training(5));
    const RowMatrixF predictions = predictions_of(s, model);
    const TrainingSet validation = s.set("validation", model);
    const std::vector<float> neutral = neutral_prediction(model.output_space());
    double sum = 0, untrained = 0;
    for (int i = 0; i < validation.size(); ++i) {
        Eigen::RowVectorXf target(validation.width());
        validation.target(i, target.data());
        const Eigen::Map<const Eigen::RowVectorXf> start(neutral.data(), target.size());
        sum += (predictions.row(24 + i) - target).cast<double>().squaredNorm() / target.size();
        untrained += (start - target).cast<double>().squaredNorm() / target.size();
    }
    const auto best = static_cast<std::size_t>(model.curve().best_epoch - 1);
    CHECK(sum / validation.size() == Approx(model.curve().validation_loss[best]).epsilon(1e-4));
    CHECK(untrained / validation.size() == Approx(model.curve().initial_validation_loss).epsilon(1e-6));
}

TEST_CASE("every variant trains")
{
    const Synthetic s = make_synthetic(48, 8);
    for (const std::string& parametrisation : names<ParametrisationKind>())
        for (const bool rotation : {true, false}) {
            CAPTURE(parametrisation, rotation);
            NetworkOptions network = small_network();
            network.parametrisation = parse_name<ParametrisationKind>(parametrisation);
            network.rotation = rotation;
            network.shape = rotation;
            const TrainingCurve curve = trained(s, network, quick_training(25)).curve();
            CHECK(curve.validation_loss[curve.best_epoch - 1] < 0.4 * curve.initial_validation_loss);
        }
    NetworkOptions linear = small_network();
    linear.widths = {};
    const TrainingCurve curve = trained(s, linear, quick_training(25)).curve();
    CHECK(curve.validation_loss.back() < 0.5 * curve.initial_validation_loss);
}

TEST_CASE("same seed, same weights; another seed, others")
{
    const Synthetic s = make_synthetic(40, 8);
    TrainingOptions options = quick_training(4);
    options.dropout = 0.2;
    options.input_noise = 0.1;
    const auto first = predictions_of(s, trained(s, small_network(), options));
    CHECK(first == predictions_of(s, trained(s, small_network(), options)));
    options.seed = 12;
    CHECK(first != predictions_of(s, trained(s, small_network(), options)));
}

TEST_CASE("a stopped run resumes where it was and ends with the same weights, bit for bit")
{
    const TemporaryFolder folder;
    const Synthetic s = make_synthetic(40, 8);  // two batches an epoch: step 7 is in the middle of the fourth
    for (const std::string& schedule : names<Schedule>()) {
        CAPTURE(schedule);
        NetworkOptions network = small_network();
        network.output_basis = schedule == "constant" ? 0 : 6;
        network.region_reach = schedule == "cosine" ? 1 : 0;
        if (network.region_reach > 0) network.parametrisation = ParametrisationKind::direct;
        TrainingOptions options = quick_training(6);
        options.schedule = parse_name<Schedule>(schedule);
        options.dropout = 0.1;
        options.input_noise = 0.05;
        options.weight_average = schedule == "plateau" ? 0.0 : 0.9;
        const NeuralModel whole = trained(s, network, options);

        options.checkpoint_path = checkpoint_path_for(folder.file(schedule));
        int steps = 0;
        TrainingCallbacks callbacks;
        callbacks.stop = [&] { return ++steps == 7; };
        CHECK_THROWS_AS(trained(s, network, options, callbacks), Interrupted);
        REQUIRE(std::filesystem::exists(options.checkpoint_path));
        callbacks.stop = [] { return false; };
        TrainingResult result;
        const NeuralModel resumed = trained(s, network, options, callbacks, &result);
        CHECK(result.resumed_epoch == 3);
        CHECK(result.epochs_run == 6);
        CHECK(resumed.curve().train_loss == whole.curve().train_loss);
        CHECK(resumed.curve().validation_loss == whole.curve().validation_loss);
        CHECK(resumed.curve().best_epoch == whole.curve().best_epoch);
        CHECK(predictions_of(s, resumed) == predictions_of(s, whole));
        remove_checkpoint(options.checkpoint_path);
        CHECK(!std::filesystem::exists(options.checkpoint_path));
    }
}

TEST_CASE("a checkpoint of another run or a damaged one is refused")
{
    const TemporaryFolder folder;
    const Synthetic s = make_synthetic(40, 8);
    TrainingOptions options = quick_training(3);
    options.checkpoint_path = checkpoint_path_for(folder.file("model.h5"));
    options.checkpoint_seconds = 0;  // after every epoch
    trained(s, small_network(), options);
    REQUIRE(std::filesystem::exists(options.checkpoint_path));
    TrainingOptions other = options;
    other.learning_rate *= 2;
    CHECK_THROWS_WITH(trained(s, small_network(), other), Catch::Contains("other options"));
    Synthetic more = make_synthetic(48, 8);
    CHECK_THROWS_WITH(trained(more, small_network(), options), Catch::Contains("other options"));
    CHECK_NOTHROW(trained(s, small_network(), options));  // finished already: nothing left to do
    std::ofstream(options.checkpoint_path) << "not a checkpoint";
    CHECK_THROWS_WITH(trained(s, small_network(), options), Catch::Contains("not a readable"));
}

TEST_CASE("patience stops a run that no longer improves")
{
    const Synthetic s = make_synthetic(16, 4);
    TrainingOptions options = quick_training(2000);
    options.schedule = Schedule::constant;
    options.patience = 4;
    TrainingResult result;
    const NeuralModel model = trained(s, small_network(), options, {}, &result);
    CHECK(result.stopped_early);
    CHECK(result.epochs_run == model.curve().best_epoch + 4);
    CHECK(result.epochs_run < 2000);
}

TEST_CASE("a diverging run says so")
{
    const Synthetic s = make_synthetic(16, 4);
    TrainingOptions options = quick_training(200);
    options.schedule = Schedule::constant;
    options.learning_rate = 10;
    NetworkOptions network = small_network();
    network.widths = {};
    CHECK_THROWS_WITH(trained(s, network, options), Catch::Contains("learning rate"));
}

TEST_CASE("a model and samples that do not fit each other are refused")
{
    const Synthetic s = make_synthetic(16, 4);
    NetworkOptions without_shape = small_network();
    without_shape.shape = false;
    NeuralModel model = s.model(without_shape);
    const NeuralModel other = s.model(small_network());
    CHECK_THROWS_AS(train(model, s.set("train", other), s.set("validation", other), quick_training(1)), InputError);
}

TEST_CASE("two threads give the losses of one, but for the order of sums")
{
    const Synthetic s = make_synthetic(96, 24);
    NetworkOptions network = small_network();
    TrainingOptions options = quick_training(6);
    for (const Precision precision : precisions()) {
        CAPTURE(to_name(precision));
        options.precision = precision;
        set_num_threads(1);
        const TrainingCurve one = trained(s, network, options).curve();
        set_num_threads(2);
        const TrainingCurve two = trained(s, network, options).curve();
        set_num_threads(1);
        for (std::size_t i = 0; i < one.epoch.size(); ++i) {
            CHECK(two.train_loss[i] == Approx(one.train_loss[i]).epsilon(1e-3));
            CHECK(two.validation_loss[i] == Approx(one.validation_loss[i]).epsilon(1e-3));
        }
    }
}

TEST_CASE("bfloat16 products learn as well as float32 ones")
{
    const Synthetic s = make_synthetic();
    TrainingOptions options = quick_training(80);
    options.precision = Precision::float32;
    const double exact = trained(s, small_network(), options).curve().validation_loss.back();
    for (const Precision precision : precisions()) {
        options.precision = precision;
        CHECK(trained(s, small_network(), options).curve().validation_loss.back() < 1.3 * exact);
    }
}

TEST_CASE("a checkpoint that cannot be written ends the run with its name")
{
    const TemporaryFolder folder;
    const Synthetic s = make_synthetic(16, 4);
    TrainingOptions options = quick_training(4);
    options.checkpoint_path = folder.file("no-such-folder/model.h5.checkpoint");
    options.checkpoint_seconds = 0;
    CHECK_THROWS_WITH(trained(s, small_network(), options), Catch::Contains("no-such-folder"));
}
