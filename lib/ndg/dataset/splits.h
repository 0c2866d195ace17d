// SPDX-License-Identifier: Apache-2.0
// Bodies and poses of training, validation and testing, and the samples of each: format "ndg-splits" (docs/formats.md).
#pragma once

#include "ndg/core/provenance.h"
#include "ndg/dataset/sample_index.h"

#include <map>
#include <string>
#include <vector>

namespace ndg {

struct Splits {
    std::map<std::string, std::vector<int>> bodies;        ///< split -> body indices
    std::map<std::string, std::vector<int>> poses;         ///< split -> pose indices
    std::map<std::string, std::vector<SamplePair>> pairs;  ///< split -> samples, without repetition
};
void write_splits(const std::string& path, const Splits& splits, const Provenance& provenance);
/// Checks ranges (num_bodies, num_poses; -1: unchecked), that splits are disjoint and that pairs keep to their split.
Splits read_splits(const std::string& path, int num_bodies = -1, int num_poses = -1);

}  // namespace ndg
