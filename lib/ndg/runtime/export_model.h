// SPDX-License-Identifier: Apache-2.0
// From a trained network (format "ndg-model") to what the runtime maps into memory.
#pragma once

#include "ndg/core/options.h"
#include "ndg/runtime/runtime_model.h"

#include <string>

namespace ndg {

/// How weights are kept.
struct RuntimeWeights {
    /// The last layer, or the fixed basis: nearly all of a network, and what a frame waits for.
    WeightStorage last_layer = WeightStorage::int8;
    WeightStorage hidden_layers = WeightStorage::bfloat16;
};
void describe(OptionList& list, RuntimeWeights& options);

/// Prisms that a part gives, filled up with -1 to whole groups.
std::vector<int> fill_groups(std::vector<int> prisms);

/// Reads a model row by row and writes it as format "ndg-runtime". Throws InputError for a damaged file and for what
/// the runtime does not know: networks that predict vertices, and the parametrisations lu and qr.
void export_runtime_model(const std::string& model_path, const RuntimeWeights& weights, const std::string& output_path,
                          const Provenance& provenance);

}  // namespace ndg
