// SPDX-License-Identifier: Apache-2.0
// The report folder: tables.json, results.md, index.html.
#pragma once

#include "ndg/core/provenance.h"
#include "ndg/evaluate/tables.h"

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <vector>

namespace ndg {

struct Report {
    std::string split;                        ///< which split was evaluated
    std::vector<MethodMetrics> rows;          ///< of Table 1
    std::vector<MethodMetrics> variants;      ///< of Table 4, below NDG's own row
    std::vector<MethodMetrics> beyond_paper;  ///< methods that the paper has not
    std::string unseen_path;                  ///< tables.json of the body outside the training distribution; or empty
    std::string protrusion_path;              ///< of measure-protrusion; or empty
    TableCounts counts;
    std::string seconds_json = "{}";    ///< JSON object: stage -> seconds
    std::vector<std::string> licences;  ///< credit lines of the data the results were made from
    std::string command;                ///< that made the report
    std::vector<Provenance::Input> inputs;
};

/// docs/formats.md, Report; rows in order. Throws InputError when `seconds_json` is not an object of numbers, or when
/// the files of Tables 2 and 3 are not what those tools write.
std::string tables_json(const Report& report);
/// The same for readers, with the paper's figures and ratios beside ours.
std::string results_markdown(const Report& report);
/// One self-contained page: the tables, distributions, and the PNG files given by their paths.
std::string report_page(const Report& report, const std::vector<std::string>& picture_paths);

/// Writes `tables_path`, and results.md and index.html beside it; the page shows the PNG files found in that folder.
void write_report(const std::string& tables_path, const Report& report);

/// Content of a JSON file as text. Throws InputError when it cannot be read or is not a JSON object of numbers.
std::string read_seconds(const std::string& path);

/// A heading, a table of texts whose first row is its head, and notes above and below it.
struct ReportSection {
    std::string title, note;
    std::vector<std::vector<std::string>> table;
    std::string legend;
};
/// What Markdown and page both show, from the tables as tables_json has them.
std::vector<ReportSection> report_sections(const Report& report, const nlohmann::ordered_json& tables);

}  // namespace ndg
