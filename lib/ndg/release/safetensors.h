// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace ndg {

/// Writes the numbers of a trained network (format "ndg-model") as safetensors (github.com/huggingface/safetensors,
/// "Format"): eight bytes of length, a header in JSON, then the numbers, little-endian and row-major, as they stand in
/// the file bit for bit. "/network/layer_0/weight" is called "network.layer_0.weight"; the attributes of the file are
/// the header's "__metadata__". Throws InputError for a damaged model, Error where nothing can be written.
void write_safetensors(const std::string& path, const std::string& model_path);

}  // namespace ndg
