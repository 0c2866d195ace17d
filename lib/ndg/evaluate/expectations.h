// SPDX-License-Identifier: Apache-2.0
// What the tables of a run must show, held against what they show (configs/expectations/, docs/formats.md).
#pragma once

#include <string>
#include <vector>

namespace ndg {

struct CheckedExpectation {
    std::string text;  ///< the expectation and what was found
    bool holds = false;
};

/// All expectations of one file against one tables.json, in the file's order of tables (alphabetical) and in each table
/// orders, ratios, ranges. A table's section has
///   "order"   measure -> methods, of which each must have less than the next
///   "ratios"  list of {"methods": [a, b], "tolerance": t, measure: r...}: a's measure over b's lies within [r/(1+t), r
///   (1+t)] "ranges"  method -> measure -> [lowest, highest]
/// and "counts" has quantity -> [lowest, highest]. Throws InputError naming file and place: what is no such section,
/// or a table, method or measure that the tables lack.
std::vector<CheckedExpectation> check_expectations(const std::string& tables_path,
                                                   const std::string& expectations_path);

}  // namespace ndg
