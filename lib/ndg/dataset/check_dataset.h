// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"
#include "ndg/dataset/splits.h"

#include <string>
#include <vector>

namespace ndg {

/// Reads everything: every pair of the splits once and no other, every coordinate finite, no two samples alike, all of
/// `statistics` there and the stop reasons, and of a virtual dataset every shard unchanged since it was merged and made
/// with the same key. One sentence for each defect.
std::vector<std::string> check_dataset(const std::string& dataset, const Splits& splits,
                                       const std::vector<std::string>& statistics);

/// Whether these vertices (N_v x 3) are, bit for bit, those that `dataset` holds for the sample, in a sentence; ""
/// where it has none.
std::string compare_with_stored(const SampleKey& key, const Points& vertices, const std::string& dataset);

}  // namespace ndg
