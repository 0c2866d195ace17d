// SPDX-License-Identifier: Apache-2.0
// Internal to this module (includes libtorch): what training minimises (NDG equation 17).
#pragma once

#include "ndg/neural/augmentation.h"
#include "ndg/neural/network.h"

#include <torch/types.h>

#include <memory>

namespace ndg {

/// The mean squared error of predictions of one set's samples, per predicted number.
class Objective {
public:
    virtual ~Objective() = default;

    /// What the network is asked for.
    virtual LastLayer last_layer() const = 0;
    /// Numbers of a target.
    virtual int width() const = 0;
    /// What a sample's outputs are compared with. May be called by any thread.
    virtual void target(int sample_idx, const SampleChange& change, float* target) const = 0;
    /// Of what last_layer() says, (B, ...), and of B targets; differentiable.
    virtual torch::Tensor loss(const torch::Tensor& outputs, const torch::Tensor& targets) const = 0;
    /// Of the neutral prediction.
    virtual double neutral_loss(const torch::Tensor& targets) const = 0;
};

/// `augmentation`: of the set, or null. Keeps references to set, augmentation and space. Where all parts of the network
/// have a basis and predictions are the neutral one and the outputs added, the coefficients that a sample asks for are
/// found once, and its loss is that of the coefficients and what the basis cannot hold: the same loss, but for rounding
/// and for changed samples, of which what the basis cannot hold is taken to be that of the unchanged ones.
std::unique_ptr<Objective> make_objective(const TrainingSet& set, const Augmentation* augmentation,
                                          const OutputSpace& output_space, const Network& network, Device device);

}  // namespace ndg
