// SPDX-License-Identifier: Apache-2.0
// A network, the space of what it sees and the space of what it predicts (NDG section 4.4).
#pragma once

#include "ndg/core/provenance.h"
#include "ndg/neural/options.h"
#include "ndg/neural/output_space.h"
#include "ndg/runtime/input_space.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace ndg {

/// Losses of the epochs, in order: mean squared errors per predicted number (NDG equation 17).
struct TrainingCurve {
    std::vector<int> epoch;  ///< 1, 2, ...
    std::vector<double> train_loss, validation_loss;
    double initial_train_loss = 0, initial_validation_loss = 0;  ///< of the neutral prediction
    int best_epoch = 0;                                          ///< whose weights the model has; 0: none trained
};

class NeuralModel {
public:
    /// An untrained model: its predictions are the neutral one. The template's file_sha256 is kept to recognise it.
    /// Throws InputError for options or a shape space that do not fit.
    NeuralModel(const NetworkOptions& options, const ShapeSpace& shape_space, const Template& body_template,
                std::uint64_t seed, Device device = Device::cpu);
    /// The same with an output space of the caller's own instead of the one options.output_space names.
    NeuralModel(const NetworkOptions& options, const ShapeSpace& shape_space, const Template& body_template,
                std::shared_ptr<const OutputSpace> output_space, std::uint64_t seed, Device device = Device::cpu);
    ~NeuralModel();
    NeuralModel(NeuralModel&&) noexcept;
    NeuralModel& operator=(NeuralModel&&) noexcept;

    /// File format "ndg-model", version 2 (docs/formats.md). Throws InputError naming file and item when the file is
    /// damaged or was made for another template.
    static NeuralModel load(const std::string& path, const Template& body_template, Device device = Device::cpu);
    void save(const std::string& path, const Provenance& provenance) const;

    const NetworkOptions& options() const;
    const InputSpace& input_space() const;
    const OutputSpace& output_space() const;
    const TrainingCurve& curve() const;
    std::int64_t num_parameters() const;

    /// One row of output_space().width() numbers a sample. Not to be called from several threads at once. A sample's
    /// result may differ in rounding with the number of samples given together.
    RowMatrixF predict(const std::vector<PoseInput>& inputs) const;

    /// Internal to this module.
    struct State;
    State& state() { return *state_; }

private:
    std::unique_ptr<State> state_;
};

}  // namespace ndg
