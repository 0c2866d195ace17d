// SPDX-License-Identifier: Apache-2.0
// What runs on a GPU gives what the CPU gives. Skips where there is none.
#include "ndg/neural/train.h"

#include "ndg/core/error.h"
#include "ndg/geometry/matrix_exponential.h"
#include "ndg/neural/parametrisation.h"
#include "synthetic.h"

#include <torch/autograd.h>
#include <catch2/catch.hpp>

using namespace ndg;
using namespace ndg::test;

namespace {

bool skipped()
{
    try {
        require_available(Device::cuda);
        return false;
    } catch (const InputError& error) {
        WARN("skipped: " << error.what());
        return true;
    }
}

TrainingOptions few_steps()
{
    TrainingOptions options;
    options.epochs = 4;
    options.learning_rate = 5e-3;
    options.schedule = Schedule::cosine;
    options.precision = Precision::float32;
    options.seed = 11;
    return options;
}

NeuralModel trained_on(Device device, const Synthetic& s, const NetworkOptions& network, const TrainingOptions& options)
{
    NeuralModel model = s.model(network, device);
    train(model, s.set("train", model), s.set("validation", model), options);
    return model;
}

}  // namespace

TEST_CASE("a GPU's matrix exponentials and their derivatives are those of our kernel")
{
    if (skipped()) return;
    Random random(3, "matrices");
    constexpr std::int64_t count = 1000;
    torch::Tensor matrices = torch::empty({count, 9}), gradient = torch::empty({count, 9});
    for (std::int64_t i = 0; i < 9 * count; ++i) {
        matrices.data_ptr<float>()[i] = static_cast<float>(random.normal() * (i % 7 == 0 ? 1.5 : 0.3));
        gradient.data_ptr<float>()[i] = static_cast<float>(random.normal());
    }
    const auto on = [&](torch::DeviceType device) {
        const torch::Tensor q = matrices.to(device).requires_grad_();
        const torch::Tensor e = differentiable_exponential(q);
        const torch::Tensor q_gradient = torch::autograd::grad({e}, {q}, {gradient.to(device)})[0];
        return std::make_pair(e.detach().cpu(), q_gradient.cpu());
    };
    const auto [cpu_values, cpu_gradients] = on(torch::kCPU);
    const auto [gpu_values, gpu_gradients] = on(torch::kCUDA);
    const torch::Tensor scale = cpu_values.norm(2, {1}, true), gradient_scale = cpu_gradients.norm(2, {1}, true);
    CHECK(((gpu_values - cpu_values) / scale).abs().max().item<double>() < 2e-6);
    CHECK(((gpu_gradients - cpu_gradients) / gradient_scale).abs().max().item<double>() < 1e-5);
}

TEST_CASE("training on a GPU takes the path it takes on the CPU")
{
    if (skipped()) return;
    const Synthetic s = make_synthetic();
    NetworkOptions network = small_network();
    TrainingOptions options = few_steps();
    SECTION("a trained last layer and the matrix exponential") {}
    SECTION("a fixed basis, in the space of coefficients")
    {
        network.parametrisation = ParametrisationKind::direct;
        network.output_basis = 20;
    }
    SECTION("a fixed basis under the exponential")
    {
        network.output_basis = 20;
    }
    SECTION("LU")
    {
        network.parametrisation = ParametrisationKind::lu;
    }
    SECTION("QR")
    {
        network.parametrisation = ParametrisationKind::qr;
    }
    SECTION("vertices")
    {
        network.output_space = "vertex-offsets";
    }
    SECTION("a network for each region")
    {
        network.region_reach = 1;
    }
    SECTION("the average of the weights")
    {
        options.weight_average = 0.9;
    }

    const NeuralModel cpu = trained_on(Device::cpu, s, network, options);
    const NeuralModel gpu = trained_on(Device::cuda, s, network, options);
    for (std::size_t i = 0; i < cpu.curve().epoch.size(); ++i) {
        CAPTURE(i);
        CHECK(gpu.curve().train_loss[i] == Approx(cpu.curve().train_loss[i]).epsilon(0.02));
        CHECK(gpu.curve().validation_loss[i] == Approx(cpu.curve().validation_loss[i]).epsilon(0.02));
    }
    CHECK(cpu.curve().train_loss.back() < 0.97 * cpu.curve().initial_train_loss);
}

TEST_CASE("a model trained on a GPU predicts the same on the CPU")
{
    if (skipped()) return;
    const Synthetic s = make_synthetic();
    const NeuralModel gpu = trained_on(Device::cuda, s, small_network(), few_steps());
    const TemporaryFolder folder;
    const std::string path = folder.file("model.h5");
    gpu.save(path, {});
    const NeuralModel cpu = NeuralModel::load(path, s.tube, Device::cpu);
    const std::vector<PoseInput> inputs = {s.input(gpu, 6, 100), s.input(gpu, 7, 101)};
    CHECK((gpu.predict(inputs) - cpu.predict(inputs)).cwiseAbs().maxCoeff() < 1e-5F);
}

namespace {

/// Trains on a GPU, with a checkpoint at once, until two epochs are done.
void train_two_epochs(const Synthetic& s, const TrainingOptions& options)
{
    NeuralModel model = s.model(small_network(), Device::cuda);
    const TrainingSet training = s.set("train", model), validation = s.set("validation", model);
    int epochs = 0;
    TrainingCallbacks callbacks;
    callbacks.epoch_done = [&](const TrainingCurve&, double) { ++epochs; };
    callbacks.stop = [&] { return epochs == 2; };
    CHECK_THROWS_AS(train(model, training, validation, options, callbacks), Interrupted);
}

/// Goes on from there with a new model.
TrainingResult resume(const Synthetic& s, const TrainingOptions& options, NeuralModel& model)
{
    const TrainingSet training = s.set("train", model), validation = s.set("validation", model);
    return train(model, training, validation, options);
}

}  // namespace

TEST_CASE("a run on a GPU resumes where it was stopped")
{
    if (skipped()) return;
    const Synthetic s = make_synthetic();
    TrainingOptions options = few_steps();
    const NeuralModel whole = trained_on(Device::cuda, s, small_network(), options);
    const TemporaryFolder folder;
    options.checkpoint_path = checkpoint_path_for(folder.file("model.h5"));
    options.checkpoint_seconds = 0;
    train_two_epochs(s, options);
    NeuralModel resumed = s.model(small_network(), Device::cuda);
    CHECK(resume(s, options, resumed).resumed_epoch == 2);
    CHECK(resumed.curve().validation_loss.back() == Approx(whole.curve().validation_loss.back()).epsilon(1e-3));
}

TEST_CASE("a run on a GPU goes on on a machine without one")
{
    if (skipped()) return;
    const Synthetic s = make_synthetic();
    TrainingOptions options = few_steps();
    options.precision = Precision::float32;
    const TemporaryFolder folder;
    options.checkpoint_path = checkpoint_path_for(folder.file("model.h5"));
    options.checkpoint_seconds = 0;
    train_two_epochs(s, options);
    NeuralModel resumed = s.model(small_network(), Device::cpu);
    CHECK(resume(s, options, resumed).resumed_epoch == 2);
}
