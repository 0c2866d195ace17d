// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/registration/fit_body.h"

#include <string>

namespace ndg {

/// A finished scan of a batch, double precision. The report comes back as it was written.
void write_fit_part(const std::string& path, const FittedBody& fitted);
/// Throws InputError for anything but a whole part.
FittedBody read_fit_part(const std::string& path);

}  // namespace ndg
