// SPDX-License-Identifier: Apache-2.0
// The samples that one process makes: all of a dataset, or a shard of it.
#pragma once

#include "ndg/dataset/splits.h"

#include <string>
#include <vector>

namespace ndg {

/// Every `count`-th pair from `index` on; 0 <= index < count.
struct Shard {
    int index = 0, count = 1;
};
/// "i/n"; throws InputError for anything else.
Shard parse_shard(const std::string& text);

/// A pair with its split and its place in the list of all pairs of all splits.
struct SampleTask {
    int sample_idx = 0;
    SamplePair pair;
    std::string split;

    SampleKey key() const { return {split, pair}; }
};
/// All pairs in order of splits, of them those of the shard. Throws InputError when none is left.
std::vector<SampleTask> sample_tasks(const Splits& splits, const Shard& shard);

/// Attribute of a deformation file: what its samples depend on besides their pair. Samples of two keys are not mixed.
inline const std::string sample_key_attribute = "simulation_key";

/// Whether `output` holds these tasks already. Throws InputError when it holds something else.
bool holds_samples(const std::string& output, const std::string& key, const std::vector<SampleTask>& tasks);

}  // namespace ndg
