// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/train.h"

#include "ndg/core/error.h"
#include "ndg/core/interrupt.h"
#include "ndg/core/log.h"
#include "ndg/core/provenance.h"
#include "ndg/core/random.h"
#include "ndg/core/threads.h"
#include "ndg/neural/adamw.h"
#include "ndg/neural/checkpoint.h"
#include "ndg/neural/matrix_product.h"
#include "ndg/neural/model_state.h"
#include "ndg/neural/objective.h"
#include "ndg/neural/output_basis.h"
#include "ndg/neural/target_loader.h"
#include "ndg/neural/weight_average.h"

#include <torch/utils.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <optional>
#include <system_error>

namespace ndg {
namespace {

using torch::Tensor;
using Clock = std::chrono::steady_clock;

constexpr int plateau_patience = 5;
constexpr double plateau_factor = 0.5;
constexpr double checkpoint_share = 0.02;  ///< of the time, at most

/// One training run: its options, its data, and its state between two steps.
class Trainer {
public:
    Trainer(NeuralModel::State& model, const TrainingSet& training, const TrainingSet& validation,
            const TrainingOptions& options, const TrainingCallbacks& callbacks);
    TrainingResult run();

private:
    std::string fingerprint() const;
    void start_or_resume(TrainingResult& result);
    void train_epoch();
    void train_batch(const TargetLoader::Batch& batch);
    void finish_epoch();
    /// Mean losses of the network and, before the first epoch is over, of the neutral prediction (otherwise 0).
    struct Losses {
        double network = 0, neutral = 0;
    };
    Losses validation_losses() const;
    /// Whose validation loss counts, and whose weights become the model's.
    const Network& result() const { return average_ ? average_->network() : model_.network; }
    bool in_first_epoch() const { return state_.curve.epoch.empty(); }
    double batch_learning_rate() const;
    /// Rows of features of some samples, as they are or with noise and changes.
    RowMatrixF inputs_of(const TrainingSet& set, const std::vector<int>& samples, bool augmented) const;
    Tensor on_device(const Tensor& tensor) const { return tensor.to(torch_device(model_.device), true); }
    /// The tensors that a checkpoint holds are those in use.
    void keep_state();
    void save_checkpoint();
    void save_if_due();
    bool stop_requested() const { return callbacks_.stop ? callbacks_.stop() : interrupt_requested(); }
    int batches_per_epoch() const { return (training_.size() + options_.batch_size - 1) / options_.batch_size; }

    NeuralModel::State& model_;
    const TrainingSet& training_;
    const TrainingSet& validation_;
    const TrainingOptions& options_;
    const TrainingCallbacks& callbacks_;
    Eigen::RowVectorXf noise_scale_;
    Precision precision_;
    std::optional<Augmentation> augmentation_;
    std::unique_ptr<Objective> training_objective_, validation_objective_;
    Checkpoint state_;
    std::vector<Tensor> parameters_;
    std::optional<NetworkPass> pass_;
    std::optional<AdamW> optimizer_;
    std::optional<WeightAverage> average_;
    CheckpointWriter writer_;
    Clock::time_point last_save_ = Clock::now();
};

Trainer::Trainer(NeuralModel::State& model, const TrainingSet& training, const TrainingSet& validation,
                 const TrainingOptions& options, const TrainingCallbacks& callbacks)
    : model_(model),
      training_(training),
      validation_(validation),
      options_(options),
      callbacks_(callbacks),
      precision_(resolve_precision(options.precision, model.device)),
      writer_(options.checkpoint_path)
{
    if (options.augmentation.any())
        augmentation_.emplace(training, model.input_space, *model.output_space, options.augmentation, options.seed);
    const RowMatrixF& features = training.features();
    const Eigen::RowVectorXf mean = features.colwise().mean();
    noise_scale_ =
        ((features.rowwise() - mean).colwise().squaredNorm() / static_cast<float>(features.rows())).cwiseSqrt().eval();
}

std::string Trainer::fingerprint() const
{
    return run_key("training", training_method_version, options_key(model_.options) + options_key(options_),
                   {to_name(precision_), model_.template_sha256, std::to_string(model_.seed),
                    std::to_string(model_.output_space->width()), training_.digest(), validation_.digest()});
}

RowMatrixF Trainer::inputs_of(const TrainingSet& set, const std::vector<int>& samples, bool augmented) const
{
    RowMatrixF rows(samples.size(), set.features().cols());
    for (std::size_t i = 0; i < samples.size(); ++i) {
        if (augmented && augmentation_)
            rows.row(i) = augmentation_->features(samples[i], augmentation_->draw(samples[i], state_.epoch));
        else
            rows.row(i) = set.features().row(samples[i]);
    }
    const double noise = augmented ? options_.input_noise : 0.0;
    if (noise > 0) {
        Random random(options_.seed, "input noise", static_cast<std::uint64_t>(state_.num_steps));
        for (Eigen::Index i = 0; i < rows.rows(); ++i)
            for (Eigen::Index k = 0; k < rows.cols(); ++k)
                if (noise_scale_[k] > 0) rows(i, k) += noise_scale_[k] * static_cast<float>(noise * random.normal());
    }
    return rows;
}

Trainer::Losses Trainer::validation_losses() const
{
    const torch::NoGradGuard no_grad;
    const Objective& objective = *validation_objective_;
    const int num_samples = validation_.size();
    Losses sums;
    std::vector<int> order(num_samples);
    std::iota(order.begin(), order.end(), 0);
    TargetLoader loader([&](int sample_idx, float* target) { objective.target(sample_idx, {}, target); },
                        objective.width(), order, options_.batch_size, 0, model_.device);
    for (int done = 0; done < num_samples;) {
        const TargetLoader::Batch batch = loader.next();
        const Tensor targets = on_device(batch.targets);
        const Tensor inputs = on_device(tensor_from(inputs_of(validation_, batch.samples, false)));
        const auto count = static_cast<int>(batch.samples.size());
        const Tensor outputs = result().forward(inputs, objective.last_layer());
        sums.network += count * objective.loss(outputs, targets).item<double>();
        if (in_first_epoch()) sums.neutral += count * objective.neutral_loss(targets);
        done += count;
    }
    return {sums.network / num_samples, sums.neutral / num_samples};
}

void Trainer::start_or_resume(TrainingResult& result)
{
    const std::string& path = options_.checkpoint_path;
    const std::string current_fingerprint = path.empty() ? "" : fingerprint();
    const bool resume = !path.empty() && std::filesystem::exists(path);
    if (resume) {
        state_ = read_checkpoint(path);
        require_input(state_.fingerprint == current_fingerprint,
                      "{}: the checkpoint belongs to a run with other options or samples; remove it to start afresh",
                      path);
        result.resumed_epoch = state_.epoch;
        log_info("resuming at epoch {}, batch {} from {}", state_.epoch + 1, state_.batch + 1, path);
    } else {
        state_.fingerprint = current_fingerprint;
        state_.learning_rate = options_.learning_rate;
    }
    const Augmentation* augmentation = augmentation_ ? &*augmentation_ : nullptr;
    std::vector<RowMatrixF> bases;
    if (resume)
        for (const Tensor& basis : state_.bases) bases.push_back(TorchNetwork::matrix(basis));
    else if (model_.options.output_basis > 0)
        bases = fit_output_bases(training_, augmentation, *model_.output_space, model_.columns, model_.options,
                                 options_.seed);
    Network& network = model_.network;
    network = model_.new_network(bases);
    state_.bases = network.bases();
    training_objective_ = make_objective(training_, augmentation, *model_.output_space, network, model_.device);
    validation_objective_ = make_objective(validation_, nullptr, *model_.output_space, network, model_.device);
    network.to(model_.device);
    parameters_ = network.parameters();
    pass_.emplace(network, precision_, training_objective_->last_layer());
    optimizer_.emplace(parameters_, pass_->copies(), options_.weight_decay);
    if (options_.weight_average > 0) average_.emplace(network, options_.weight_average);
    if (!resume) return;
    const torch::NoGradGuard no_grad;
    require_input(state_.parameters.size() == parameters_.size(),
                  "{}: the checkpoint has {} tensors where the network has {}", path, state_.parameters.size(),
                  parameters_.size());
    for (std::size_t i = 0; i < parameters_.size(); ++i) {
        parameters_[i].copy_(state_.parameters[i]);
        optimizer_->first_moments[i].copy_(state_.first_moments[i]);
        optimizer_->second_moments[i].copy_(state_.second_moments[i]);
    }
    if (average_)
        for (std::size_t i = 0; i < parameters_.size(); ++i) average_->parameters()[i].copy_(state_.averages[i]);
    pass_->refresh_copies();
    optimizer_->num_steps = state_.num_steps;
    keep_state();  // not the memory of what was read
}

void Trainer::keep_state()
{
    state_.parameters = parameters_;
    state_.first_moments = optimizer_->first_moments;
    state_.second_moments = optimizer_->second_moments;
    if (average_) state_.averages = average_->parameters();
}

void Trainer::save_checkpoint()
{
    if (!options_.checkpoint_path.empty()) {
        keep_state();
        writer_.start(state_);
    }
    last_save_ = Clock::now();
}

void Trainer::save_if_due()
{
    if (stop_requested()) {
        save_checkpoint();
        writer_.finish();
        throw Interrupted(
            options_.checkpoint_path.empty()
                ? fmt::format("training stopped in epoch {}", state_.epoch + 1)
                : fmt::format("training stopped in epoch {}; run the same command again to resume from {}",
                              state_.epoch + 1, options_.checkpoint_path));
    }
    if (options_.checkpoint_seconds == 0) {
        if (state_.batch == 0) save_checkpoint();
        return;
    }
    const double elapsed = std::chrono::duration<double>(Clock::now() - last_save_).count();
    if (elapsed < options_.checkpoint_seconds || writer_.busy()) return;
    if (elapsed >= writer_.seconds() / checkpoint_share) save_checkpoint();
}

double Trainer::batch_learning_rate() const
{
    if (options_.schedule != Schedule::cosine) return state_.learning_rate;
    const double total = static_cast<double>(options_.epochs) * batches_per_epoch();
    const double done = static_cast<double>(state_.epoch) * batches_per_epoch() + state_.batch;
    return 0.5 * options_.learning_rate * (1 + std::cos(EIGEN_PI * done / total));
}

void Trainer::train_batch(const TargetLoader::Batch& batch)
{
    const double learning_rate = batch_learning_rate();
    // One seed a step, so that a resumed run draws the same dropout masks.
    torch::manual_seed(Random(options_.seed, "dropout", static_cast<std::uint64_t>(state_.num_steps)).next());
    const RowMatrixF inputs = inputs_of(training_, batch.samples, true);
    const Tensor targets = on_device(batch.targets);
    const Tensor outputs = pass_->forward(on_device(tensor_from(inputs)), options_.dropout);
    const Tensor loss = training_objective_->loss(outputs, targets);
    const double value = loss.item<double>();
    require(std::isfinite(value), "the training loss is {} in epoch {}: the learning rate {} is too high", value,
            state_.epoch + 1, learning_rate);
    loss.backward();
    optimizer_->begin_step(learning_rate);
    pass_->backward(outputs.grad(), *optimizer_);
    state_.num_steps = optimizer_->num_steps;
    if (average_) average_->update(state_.num_steps);
    const auto count = static_cast<double>(batch.samples.size());
    state_.loss_sum += count * value;
    if (in_first_epoch()) {
        const torch::NoGradGuard no_grad;
        state_.neutral_sum += count * training_objective_->neutral_loss(targets);
    }
    ++state_.batch;
}

void Trainer::train_epoch()
{
    {
        TargetLoader loader(
            [this](int sample_idx, float* target) {
                const SampleChange change =
                    augmentation_ ? augmentation_->draw(sample_idx, state_.epoch) : SampleChange();
                training_objective_->target(sample_idx, change, target);
            },
            training_objective_->width(),
            Random(options_.seed, "shuffle", static_cast<std::uint64_t>(state_.epoch)).permutation(training_.size()),
            options_.batch_size, state_.batch, model_.device);
        while (state_.batch < batches_per_epoch()) {
            train_batch(loader.next());
            if (state_.batch < batches_per_epoch()) save_if_due();
        }
    }
    finish_epoch();
}

void Trainer::finish_epoch()
{
    TrainingCurve& curve = state_.curve;
    const Losses validation = validation_losses();
    const double validation_loss = validation.network;
    require(std::isfinite(validation_loss),
            "the validation loss is {} after epoch {}: the learning rate {} is too high", validation_loss,
            state_.epoch + 1, options_.learning_rate);
    if (in_first_epoch()) {
        curve.initial_train_loss = state_.neutral_sum / training_.size();
        curve.initial_validation_loss = validation.neutral;
    }
    curve.epoch.push_back(state_.epoch + 1);
    curve.train_loss.push_back(state_.loss_sum / training_.size());
    curve.validation_loss.push_back(validation_loss);
    if (curve.best_epoch == 0 || validation_loss < state_.best_validation_loss) {
        curve.best_epoch = state_.epoch + 1;
        state_.best_validation_loss = validation_loss;
        state_.bad_epochs = 0;
        state_.best_parameters.clear();
        for (const Tensor& parameter : result().parameters())
            state_.best_parameters.push_back(parameter.detach().clone());
    } else if (++state_.bad_epochs >= plateau_patience && options_.schedule == Schedule::plateau) {
        state_.bad_epochs = 0;
        state_.learning_rate *= plateau_factor;
    }
    ++state_.epoch;
    state_.batch = 0;
    state_.loss_sum = 0;
    if (callbacks_.epoch_done) callbacks_.epoch_done(curve, batch_learning_rate());
}

TrainingResult Trainer::run()
{
    TrainingResult result;
    start_or_resume(result);
    const auto out_of_patience = [&] {
        return options_.patience > 0 && state_.epoch - state_.curve.best_epoch >= options_.patience;
    };
    while (state_.epoch < options_.epochs && !out_of_patience()) {
        train_epoch();
        save_if_due();
    }
    const torch::NoGradGuard no_grad;
    for (std::size_t i = 0; i < parameters_.size(); ++i) parameters_[i].copy_(state_.best_parameters[i]);
    model_.curve = state_.curve;
    model_.precision = to_name(precision_);
    result.epochs_run = state_.epoch;
    result.stopped_early = state_.epoch < options_.epochs;
    result.best_validation_loss = state_.best_validation_loss;
    return result;
}

}  // namespace

TrainingResult train(NeuralModel& model, const TrainingSet& training, const TrainingSet& validation,
                     const TrainingOptions& options, const TrainingCallbacks& callbacks)
{
    check_options(options);
    NeuralModel::State& state = model.state();
    for (const TrainingSet* set : {&training, &validation}) {
        require_input(set->width() == state.output_space->width(),
                      "the samples have {} numbers to predict where the model has {}", set->width(),
                      state.output_space->width());
        require_input(set->features().cols() == state.input_space.width(),
                      "the samples have {} input numbers where the model has {}", set->features().cols(),
                      state.input_space.width());
    }
    torch::set_num_threads(std::max(1, num_threads()));
    return Trainer(state, training, validation, options, callbacks).run();
}

std::string checkpoint_path_for(const std::string& output_path)
{
    return output_path + ".checkpoint";
}

void remove_checkpoint(const std::string& path)
{
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
    require(!ignored, "{}: the checkpoint was not removed: {}", path, ignored.message());
}

}  // namespace ndg
