// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace ndg {

/// What this program was built for: "x86-64-v3", "x86-64" or "native" (NDG_ARCH). A program for x86-64-v3 ends at its
/// start, with one sentence and exit code 1, on a processor that lacks those instructions.
std::string processor_name();

}  // namespace ndg
