// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/estimation/estimate_tissue.h"

#include <string>
#include <vector>

namespace ndg {

/// Writes all iterations so far, in full precision.
void write_checkpoint(const std::string& path, const std::string& key,
                      const std::vector<EstimationIteration>& iterations);
/// None where there is no file. One of another key or that is damaged is refused by an InputError; with `force` it
/// counts as none.
std::vector<EstimationIteration> read_checkpoint(const std::string& path, const std::string& key, bool force);

}  // namespace ndg
