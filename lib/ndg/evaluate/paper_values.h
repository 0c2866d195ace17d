// SPDX-License-Identifier: Apache-2.0
// The figures of NDG 2026 as it prints them, for comparison.
#pragma once

#include <cmath>
#include <string>
#include <vector>

namespace ndg {

/// One row of Table 1, 2 or 4; NaN where the paper prints none.
struct PaperRow {
    const char* method;
    double position_mm, gradient_e3, inverted, volume_e3;
};
/// `table`: "table1", "table2" or "table4"; no rows for any other.
const std::vector<PaperRow>& paper_rows(const std::string& table);

/// One row of Table 3; shares in percent of the frames.
struct PaperProtrusion {
    const char* method;
    double intersecting_frames, protruding_frames, protrusion_mm;
};
const std::vector<PaperProtrusion>& paper_protrusion();

/// What a method of a table is, in a sentence; empty for one that is not known.
std::string method_in_words(const std::string& method);

}  // namespace ndg
