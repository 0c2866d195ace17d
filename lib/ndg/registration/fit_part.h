// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/dataset/part_store.h"
#include "ndg/registration/fit_body.h"

namespace ndg {

inline const PartKind scan_parts = {"ndg-fit-part", 3, "scans"};

/// A finished scan of a batch as the payload of its part, double precision. The report comes
/// back as it was written.
void write_fit(H5Writer& writer, const FittedBody& fitted);
/// Throws InputError for anything but a whole one.
FittedBody read_fit(const H5Reader& reader);

}  // namespace ndg
