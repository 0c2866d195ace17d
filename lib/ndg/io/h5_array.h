// SPDX-License-Identifier: Apache-2.0
// Arrays of HDF5 files that other programs wrote.
#pragma once

#include "ndg/io/npz.h"

#include <string>

namespace ndg {

/// A dataset of real numbers or integers of any shape, in C order; values may be no numbers. Throws InputError naming
/// file and dataset: missing, text or records, truncated. What datasets there are: list_h5 (h5.h).
NpyArray read_h5_array(const std::string& path, const std::string& name);

}  // namespace ndg
