// SPDX-License-Identifier: Apache-2.0
// Training (NDG section 4.5).
#pragma once

#include "ndg/neural/model.h"
#include "ndg/neural/training_set.h"

#include <functional>
#include <string>

namespace ndg {

/// To be raised whenever the same options and samples come to give another model: no checkpoint of an older method is
/// gone on with then.
inline constexpr int training_method_version = 3;

struct TrainingCallbacks {
    /// After each epoch: the curve so far and the learning rate of the next epoch.
    std::function<void(const TrainingCurve&, double)> epoch_done;
    /// Asked after each step; true: save a checkpoint and throw Interrupted. Unset: interrupt_requested().
    std::function<bool()> stop;
};

struct TrainingResult {
    int epochs_run = 0;          ///< of all runs, when resumed
    int resumed_epoch = -1;      ///< epoch the checkpoint had reached; -1: none was there
    bool stopped_early = false;  ///< by patience
    double best_validation_loss = 0;
};

/// Minimises the mean squared error of the predictions by AdamW. The model ends with the weights of the epoch with the
/// lowest validation loss, and holds the curve. Fully determined by the arguments: a run that is stopped and resumed
/// from its checkpoint gives the same weights, bit for bit on the same machine with the same number of threads.
/// Throws InputError for sets that do not fit the model or a checkpoint of another run, Error when the loss is no
/// longer finite, Interrupted as TrainingCallbacks says.
TrainingResult train(NeuralModel& model, const TrainingSet& training, const TrainingSet& validation,
                     const TrainingOptions& options, const TrainingCallbacks& callbacks = {});

/// Where train-ndg keeps the checkpoint of an output file; removed once the output is written.
std::string checkpoint_path_for(const std::string& output_path);
void remove_checkpoint(const std::string& path);

}  // namespace ndg
