// SPDX-License-Identifier: Apache-2.0
// A dataset in shards: DATASET.h5 is a virtual dataset over DATASET.shards/<i>-of-<n>.h5, which n processes write, each
// with DATASET.shards/<i>-of-<n>.h5.parts while it is under way. The two can be moved together.
#pragma once

#include "ndg/dataset/deformation_file.h"
#include "ndg/dataset/splits.h"
#include "ndg/fem/simulate.h"

#include <string>
#include <vector>

namespace ndg {

/// Where a shard of a dataset is written; a shard that is the whole is the dataset itself.
std::string shard_path(const std::string& dataset, const Shard& shard);
/// Number of shards that files and folders beside the dataset tell of; 0: there are none. Throws InputError when they
/// tell of several numbers.
int found_shard_count(const std::string& dataset);

struct ShardStatus {
    enum State { not_started, stopped, running, complete };
    Shard shard;
    std::string path;
    State state = not_started;
    int total = 0, done = 0, failed = 0;  ///< samples; `failed` of those that are not `done` have no deformation
    std::string process;                  ///< that works or worked on it; empty if complete or not started
    double rate_hertz = 0;                ///< of a running one, samples a second
};
/// Of every shard. `shard_count` 0: as many as are found, one if there are none.
std::vector<ShardStatus> dataset_status(const std::string& dataset, const Splits& splits, int shard_count);
/// Lines for stdout: samples, shards, rate and time left, and "unfinished" with the indices of all shards that are not
/// complete, separated by commas ("none": nothing is left to do).
std::string status_report(const std::vector<ShardStatus>& shards);

/// Writes `dataset` over its shards, in the order of the splits; no vertices are copied. `provenance` gets the shards
/// as inputs. Throws InputError when a shard is missing, incomplete or made from other inputs or options than the
/// first, or when `dataset` exists and is not a virtual one, unless `force`.
DeformationSet merge_shards(const std::string& dataset, const Splits& splits, Provenance provenance, bool force);

/// Reads everything: every pair of the splits once and no other, every coordinate finite, no two samples alike, all
/// statistics there, and of a virtual dataset every shard unchanged since it was merged and made with the same key.
/// One sentence for each defect.
std::vector<std::string> check_dataset(const std::string& dataset, const Splits& splits);

}  // namespace ndg
