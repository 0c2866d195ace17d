// SPDX-License-Identifier: Apache-2.0
// Samples through a method, one batch after the other: no result is held as a whole.
#pragma once

#include "ndg/core/provenance.h"
#include "ndg/dataset/sample_inputs.h"
#include "ndg/deform/deformer.h"

#include <functional>
#include <string>
#include <vector>

namespace ndg {

/// Poses the samples body by body (so that what a body costs is paid once) and hands them over in batches of at most
/// `batch_size`, with their indices. Throws InputError for a pair out of range, Interrupted when a signal asks for it.
void for_each_posed_batch(
    const SampleInputs& inputs, int batch_size, const std::string& task,
    const std::function<void(const std::vector<int>& sample_indices, const std::vector<PosedBody>& posed)>& use);

/// Files to write.
struct AnimationOutputs {
    std::string deformations;
    std::string anatomy;  ///< embedded anatomy of every sample; empty: none
};

/// Deforms all samples; `method`: their name in tables.
void animate_samples(const SampleInputs& inputs, Deformer& deformer, const std::string& method,
                     const AnimationOutputs& outputs, const Provenance& provenance);

}  // namespace ndg
