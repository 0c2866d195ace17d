// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/provenance.h"

#include <string>

namespace ndg {

/// Licence and credit lines of the tool and of every input, each once, in order; of an input that does not name its own
/// and is an HDF5 file, those in its attribute "licences". They go into all that is written.
std::string merge_licences(const Provenance& provenance);

}  // namespace ndg
