// SPDX-License-Identifier: Apache-2.0
// The report folder: tables.json, results.md, index.html.
#pragma once

#include "ndg/evaluate/tables.h"

#include <string>
#include <vector>

namespace ndg {

struct Report {
    std::string split;                ///< which split was evaluated
    std::vector<MethodMetrics> rows;  ///< of Table 1
    TableCounts counts;
    std::string seconds_json = "{}";    ///< JSON object: stage -> seconds
    std::vector<std::string> licences;  ///< credit lines of the data the results were made from
};

/// {"table1": {method: {"E_pos_mm", "E_grad_e3", "E_inv", "E_corner", "E_vol_e3"}}, "counts": {...}, "seconds": {...}},
/// rows in order. Throws InputError when `seconds_json` is not an object of numbers.
std::string tables_json(const Report& report);
/// The same for readers, with the paper's Table 1 beside, labelled as the paper's.
std::string results_markdown(const Report& report);
/// One self-contained page: the tables and an <img> for each picture, named relative to the page.
std::string report_page(const Report& report, const std::vector<std::string>& pictures);

/// Writes `tables_path`, and results.md and index.html beside it; the page shows the PNG files found in that folder.
void write_report(const std::string& tables_path, const Report& report);

/// Content of a JSON file as text. Throws InputError when it cannot be read or is not a JSON object of numbers.
std::string read_seconds(const std::string& path);

}  // namespace ndg
