// SPDX-License-Identifier: Apache-2.0
// Internal to this module (includes libtorch): everything a training run needs to go on as if it had not been stopped.
#pragma once

#include "ndg/neural/model.h"

#include <torch/types.h>

#include <cstdint>
#include <future>
#include <string>
#include <vector>

namespace ndg {

struct Checkpoint {
    std::string fingerprint;   ///< of options and data; a checkpoint of another run is refused
    int epoch = 0, batch = 0;  ///< the next batch to take
    double loss_sum = 0;       ///< of this epoch's batches so far, weighted by their size
    double neutral_sum = 0;    ///< the same of the neutral prediction, in the first epoch
    double learning_rate = 0;  ///< current, for the plateau schedule
    int bad_epochs = 0;        ///< since the last improvement, for the plateau schedule
    std::int64_t num_steps = 0;
    TrainingCurve curve;
    double best_validation_loss = 0;
    /// Parameters, AdamW's moments, averages of parameters (where they are asked for), best parameters; all in the
    /// order of Network::parameters.
    std::vector<torch::Tensor> parameters, first_moments, second_moments, averages, best_parameters;
    std::vector<torch::Tensor> bases;  ///< Network::bases
};

/// Writes beside `path` and renames.
void write_checkpoint(const std::string& path, const Checkpoint& checkpoint);
/// Throws InputError when the file is not a checkpoint.
Checkpoint read_checkpoint(const std::string& path);

/// Writes checkpoints of one run while it goes on.
class CheckpointWriter {
public:
    explicit CheckpointWriter(std::string path) : path_(std::move(path)) {}
    /// Waits for what is being written.
    ~CheckpointWriter();

    /// Copies parameters, moments and averages, of which it keeps the memory, and returns while the copy is written;
    /// everything else must not be changed in place. Waits for the one before. Throws Error when that one was not
    /// written.
    void start(const Checkpoint& checkpoint);
    /// Waits for what is being written. Throws Error when it was not.
    void finish();
    /// Whether one is still being written. Throws Error when it was not.
    bool busy();
    /// What the last one took of a core: copying and, where that is over, writing; 0 before the first.
    double seconds() const { return copy_seconds_ + write_seconds_; }

private:
    std::string path_;
    Checkpoint copy_;
    double copy_seconds_ = 0, write_seconds_ = 0;
    std::future<double> written_;
};

}  // namespace ndg
