// SPDX-License-Identifier: Apache-2.0
// The NDG model: network, shape space and what they were made for (NDG section 4.4).
#pragma once

#include "ndg/body/shape_space.h"
#include "ndg/body/template.h"
#include "ndg/core/provenance.h"
#include "ndg/deform/residuals.h"
#include "ndg/neural/input_space.h"
#include "ndg/neural/options.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace ndg {

/// Losses of the epochs, in order: mean squared errors per matrix entry (NDG equation 17).
struct TrainingCurve {
    std::vector<int> epoch;  ///< 1, 2, ...
    std::vector<double> train_loss, validation_loss;
    double initial_train_loss = 0, initial_validation_loss = 0;  ///< of the untrained network: gradient skinning
    int best_epoch = 0;                                          ///< whose weights the model has; 0: none trained
};

class NdgModel {
public:
    /// An untrained model: predicts the identity. `template_sha256`: hash of the template file, kept to recognise it.
    NdgModel(const NetworkOptions& options, const ShapeSpace& shape_space, const Template& body_template,
             const std::string& template_sha256, std::uint64_t seed, Device device = Device::cpu);
    ~NdgModel();
    NdgModel(NdgModel&&) noexcept;
    NdgModel& operator=(NdgModel&&) noexcept;

    /// File format "ndg-model", version 1 (docs/formats.md). Throws InputError naming file and item when the file is
    /// damaged or was made for another template.
    static NdgModel load(const std::string& path, const Template& body_template, const std::string& template_sha256,
                         Device device = Device::cpu);
    void save(const std::string& path, const Provenance& provenance) const;

    const NetworkOptions& options() const;
    const ShapeSpace& shape_space() const;
    const TrainingCurve& curve() const;
    const std::string& template_sha256() const;
    int num_prisms() const;
    std::int64_t num_parameters() const;

    /// The code of a body's rest shape, for PoseInput; encode once a body.
    Eigen::VectorXd encode(const Body& body) const;

    /// What the network itself gives, one N_p x 9 a sample: R_p^T F_p (without `rotation`: the root's rotation for
    /// R_p). Not to be called from several threads at once. A sample's result may differ in rounding with the number of
    /// samples given together.
    std::vector<GradientsF> predict_residuals(const std::vector<PoseInput>& inputs) const;
    /// F_p = R_p F_p_res, world frame: what PoissonReconstruction::reconstruct takes.
    std::vector<GradientsF> predict_gradients(const std::vector<PoseInput>& inputs) const;

    /// Internal to this module.
    struct State;
    State& state() { return *state_; }

private:
    explicit NdgModel(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace ndg
