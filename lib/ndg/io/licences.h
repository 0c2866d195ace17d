// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/provenance.h"

#include <string>

namespace ndg {

/// Licence and credit lines of the tool and of every input (of HDF5 files their attribute `licences`), each once, in
/// order, a line each.
std::string merged_licences(const Provenance& provenance);

}  // namespace ndg
