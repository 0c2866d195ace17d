// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/protrusion/body_protrusion.h"

#include <string>
#include <vector>

namespace ndg {

/// {"table3": method -> {"intersecting_frames", "protruding_frames" (percent), "protrusion_mm", "max_protrusion_mm",
/// "frames", "deepest", "intersecting_parts"}, "counts": {"table3_pairs", "table3_colliding_pairs", ...}}: rows of
/// `table`, then `external`.
std::string protrusion_json(const ProtrusionTable& table, const std::vector<ProtrusionRow>& external);

/// "part (frames)" of those that cross the skin most often.
std::vector<std::string> most_frequent(const std::map<std::string, int>& parts, std::size_t count = 5);

}  // namespace ndg
