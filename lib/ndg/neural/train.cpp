// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/train.h"

#include "ndg/core/error.h"
#include "ndg/core/interrupt.h"
#include "ndg/core/log.h"
#include "ndg/core/parallel_for.h"
#include "ndg/core/provenance.h"
#include "ndg/core/random.h"
#include "ndg/core/threads.h"
#include "ndg/neural/adamw.h"
#include "ndg/neural/checkpoint.h"
#include "ndg/neural/model_state.h"
#include "ndg/neural/output_basis.h"

#include <torch/utils.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <optional>
#include <system_error>

namespace ndg {
namespace {

using torch::Tensor;
using Clock = std::chrono::steady_clock;

constexpr int plateau_patience = 5;
constexpr double plateau_factor = 0.5;

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
    void train_batch(const std::vector<int>& order, int first, int count);
    void finish_epoch();
    double mean_loss(const TrainingSet& set) const;
    double mean_neutral_loss(const TrainingSet& set) const;
    double batch_learning_rate() const;
    /// Rows of features and of targets (on the model's device) of some samples, as they are or with noise and changes.
    RowMatrixF inputs_of(const TrainingSet& set, const int* samples, int count, bool augmented) const;
    Tensor targets_of(const TrainingSet& set, const int* samples, int count, bool augmented) const;
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
    std::optional<Augmentation> augmentation_;
    Checkpoint state_;
    std::vector<Tensor> parameters_;
    AdamW optimizer_;
    Clock::time_point last_save_ = Clock::now();
};

Trainer::Trainer(NeuralModel::State& model, const TrainingSet& training, const TrainingSet& validation,
                 const TrainingOptions& options, const TrainingCallbacks& callbacks)
    : model_(model),
      training_(training),
      validation_(validation),
      options_(options),
      callbacks_(callbacks),
      optimizer_({}, 0)
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
                   {model_.template_sha256, std::to_string(model_.seed), std::to_string(model_.output_space->width()),
                    training_.digest(), validation_.digest()});
}

RowMatrixF Trainer::inputs_of(const TrainingSet& set, const int* samples, int count, bool augmented) const
{
    RowMatrixF rows(count, set.features().cols());
    for (int i = 0; i < count; ++i) {
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

Tensor Trainer::targets_of(const TrainingSet& set, const int* samples, int count, bool augmented) const
{
    const std::int64_t width = model_.output_space->width();
    Tensor targets = torch::empty({count, width}, torch::kFloat32);
    float* data = targets.data_ptr<float>();
    parallel_for(count, [&](int i) {
        if (augmented && augmentation_)
            augmentation_->target(samples[i], augmentation_->draw(samples[i], state_.epoch), data + i * width);
        else
            set.target(samples[i], data + i * width);
    });
    return targets.to(torch_device(model_.device));
}

double Trainer::mean_loss(const TrainingSet& set) const
{
    const torch::NoGradGuard no_grad;
    double sum = 0;
    for (int first = 0; first < set.size(); first += options_.batch_size) {
        std::vector<int> samples;
        for (int i = first; i < std::min(first + options_.batch_size, set.size()); ++i) samples.push_back(i);
        const int count = static_cast<int>(samples.size());
        const Tensor predicted = model_.predict(inputs_of(set, samples.data(), count, false), 0);
        sum += count * torch::mse_loss(predicted, targets_of(set, samples.data(), count, false)).item<double>();
    }
    return sum / set.size();
}

double Trainer::mean_neutral_loss(const TrainingSet& set) const
{
    const std::vector<float> neutral = neutral_prediction(*model_.output_space);
    double sum = 0;
    std::vector<float> target(neutral.size());
    for (int i = 0; i < set.size(); ++i) {
        set.target(i, target.data());
        double squares = 0;
        for (std::size_t k = 0; k < target.size(); ++k) {
            const double difference = static_cast<double>(target[k]) - neutral[k];
            squares += difference * difference;
        }
        sum += squares / static_cast<double>(target.size());
    }
    return sum / set.size();
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
        state_.curve.initial_train_loss = mean_neutral_loss(training_);
        state_.curve.initial_validation_loss = mean_neutral_loss(validation_);
    }
    RowMatrixF basis;
    if (resume && state_.basis.defined())
        basis = TorchNetwork::matrix(state_.basis);
    else if (model_.options.output_basis > 0)
        basis = fit_output_basis(training_, augmentation_ ? &*augmentation_ : nullptr, *model_.output_space,
                                 model_.options, options_.seed);
    model_.network = model_.new_network(basis);
    state_.basis = model_.network.basis;
    model_.network.to(model_.device);
    parameters_ = model_.network.parameters();
    optimizer_ = AdamW(parameters_, options_.weight_decay);
    if (!resume) return;
    const torch::NoGradGuard no_grad;
    require_input(state_.parameters.size() == parameters_.size(),
                  "{}: the checkpoint has {} tensors where the network has {}", path, state_.parameters.size(),
                  parameters_.size());
    for (std::size_t i = 0; i < parameters_.size(); ++i) {
        parameters_[i].copy_(state_.parameters[i]);
        optimizer_.first_moments[i].copy_(state_.first_moments[i]);
        optimizer_.second_moments[i].copy_(state_.second_moments[i]);
    }
    optimizer_.num_steps = state_.num_steps;
}

void Trainer::save_checkpoint()
{
    last_save_ = Clock::now();
    if (options_.checkpoint_path.empty()) return;
    state_.parameters = parameters_;
    state_.first_moments = optimizer_.first_moments;
    state_.second_moments = optimizer_.second_moments;
    write_checkpoint(options_.checkpoint_path, state_);
    last_save_ = Clock::now();
}

void Trainer::save_if_due()
{
    if (stop_requested()) {
        save_checkpoint();
        throw Interrupted(
            options_.checkpoint_path.empty()
                ? fmt::format("training stopped in epoch {}", state_.epoch + 1)
                : fmt::format("training stopped in epoch {}; run the same command again to resume from {}",
                              state_.epoch + 1, options_.checkpoint_path));
    }
    const double elapsed = std::chrono::duration<double>(Clock::now() - last_save_).count();
    const bool due = options_.checkpoint_seconds > 0 ? elapsed >= options_.checkpoint_seconds : state_.batch == 0;
    if (due) save_checkpoint();
}

double Trainer::batch_learning_rate() const
{
    if (options_.schedule != Schedule::cosine) return state_.learning_rate;
    const double total = static_cast<double>(options_.epochs) * batches_per_epoch();
    const double done = static_cast<double>(state_.epoch) * batches_per_epoch() + state_.batch;
    return 0.5 * options_.learning_rate * (1 + std::cos(EIGEN_PI * done / total));
}

void Trainer::train_batch(const std::vector<int>& order, int first, int count)
{
    const double learning_rate = batch_learning_rate();
    // One seed a step, so that a resumed run draws the same dropout masks.
    torch::manual_seed(Random(options_.seed, "dropout", static_cast<std::uint64_t>(state_.num_steps)).next());
    const RowMatrixF inputs = inputs_of(training_, order.data() + first, count, true);
    const Tensor loss = torch::mse_loss(model_.predict(inputs, options_.dropout),
                                        targets_of(training_, order.data() + first, count, true));
    const double value = loss.item<double>();
    require(std::isfinite(value), "the training loss is {} in epoch {}: the learning rate {} is too high", value,
            state_.epoch + 1, learning_rate);
    loss.backward();
    optimizer_.step(learning_rate);
    state_.num_steps = optimizer_.num_steps;
    state_.loss_sum += count * value;
    ++state_.batch;
}

void Trainer::train_epoch()
{
    const std::vector<int> order =
        Random(options_.seed, "shuffle", static_cast<std::uint64_t>(state_.epoch)).permutation(training_.size());
    while (state_.batch < batches_per_epoch()) {
        const int first = state_.batch * options_.batch_size;
        train_batch(order, first, std::min(options_.batch_size, training_.size() - first));
        if (state_.batch < batches_per_epoch()) save_if_due();
    }
    finish_epoch();
}

void Trainer::finish_epoch()
{
    TrainingCurve& curve = state_.curve;
    const double validation_loss = mean_loss(validation_);
    require(std::isfinite(validation_loss),
            "the validation loss is {} after epoch {}: the learning rate {} is too high", validation_loss,
            state_.epoch + 1, options_.learning_rate);
    curve.epoch.push_back(state_.epoch + 1);
    curve.train_loss.push_back(state_.loss_sum / training_.size());
    curve.validation_loss.push_back(validation_loss);
    if (curve.best_epoch == 0 || validation_loss < state_.best_validation_loss) {
        curve.best_epoch = state_.epoch + 1;
        state_.best_validation_loss = validation_loss;
        state_.bad_epochs = 0;
        state_.best_parameters.clear();
        for (const Tensor& parameter : parameters_) state_.best_parameters.push_back(parameter.detach().clone());
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
