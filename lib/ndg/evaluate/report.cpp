// SPDX-License-Identifier: Apache-2.0
#include "ndg/evaluate/report.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <sstream>

namespace ndg {
namespace {

using Json = nlohmann::ordered_json;

/// Table 1 of NDG 2026: E_pos mm, E_grad 1e-3, E_inv, E_vol 1e-3; NaN where the paper prints none.
struct PaperRow {
    const char* method;
    double position_mm, gradient_e3, inverted, volume_e3;
};
const double no_value = std::nan("");
const std::array<PaperRow, 7> paper_table1 = {{{"FEM", 0.00, 0.00, 3.10, 2.05},
                                               {"NDG", 3.19, 1.11, 9.22, 3.75},
                                               {"VertexNet", 3.41, 3.01, 25.63, 13.96},
                                               {"Gradient Skinning", 6.69, 9.89, 93.99, 33.32},
                                               {"LBS", 7.56, 15.04, 167.63, 40.67},
                                               {"Projective Skinning", no_value, no_value, 11.31, 28.05},
                                               {"CoRot LinFEM", no_value, no_value, 108.18, 21.99}}};

Json parse_seconds(const std::string& text, const std::string& source)
{
    Json seconds = Json::parse(text, nullptr, false);
    require_input(!seconds.is_discarded() && seconds.is_object(), "{} is not a JSON object of seconds", source);
    for (const auto& [stage, value] : seconds.items())
        require_input(value.is_number(), "{}: the seconds of stage \"{}\" are not a number", source, stage);
    return seconds;
}

Json counts_json(const Report& report)
{
    const TableCounts& counts = report.counts;
    Json json;
    json["bodies"] = counts.bodies;
    json["poses"] = counts.poses;
    json["samples"] = counts.samples;
    json["prisms"] = counts.prisms;
    json["volume_vertices"] = counts.volume_vertices;
    json["free_vertices"] = counts.free_vertices;
    for (const auto& [split, samples] : counts.split_samples) json[split + "_samples"] = samples;
    // The split that was evaluated counts what was evaluated.
    json[report.split + "_samples"] = counts.evaluated_samples;
    json[report.split + "_left_out_unconverged"] = counts.unconverged_samples;
    json[report.split + "_left_out_failed"] = counts.failed_samples;
    json[report.split + "_bodies"] = counts.evaluated_bodies;
    json[report.split + "_poses"] = counts.evaluated_poses;
    json["fem_converged_share"] = counts.fem_converged_share;
    json["fem_convergence_criterion"] = counts.fem_convergence_criterion;
    json["invalid_rest_prisms"] = counts.invalid_rest_prisms;
    return json;
}

std::string figure(double value, int digits)
{
    return std::isnan(value) ? "-" : fmt::format("{:.{}f}", value, digits);
}

using TextTable = std::vector<std::vector<std::string>>;

TextTable our_table(const Report& report)
{
    TextTable table = {{"Method", "E_pos [mm]", "E_grad [1e-3]", "E_inv", "E_corner", "E_vol [1e-3]"}};
    for (const MethodMetrics& row : report.rows)
        table.push_back({row.method, figure(row.mean.position_error_mm, 3), figure(1e3 * row.mean.gradient_error, 3),
                         figure(row.mean.inverted_prisms, 2), figure(row.mean.corner_inverted_prisms, 2),
                         figure(1e3 * row.mean.volume_error, 3)});
    return table;
}

TextTable paper_table()
{
    TextTable table = {{"Method (paper)", "E_pos [mm]", "E_grad [1e-3]", "E_inv", "E_vol [1e-3]"}};
    for (const PaperRow& row : paper_table1)
        table.push_back({row.method, figure(row.position_mm, 2), figure(row.gradient_e3, 2), figure(row.inverted, 2),
                         figure(row.volume_e3, 2)});
    return table;
}

std::string value_text(const Json& value)
{
    return value.is_string() ? value.get<std::string>() : value.dump();
}

TextTable object_table(const Json& object, const std::string& key_title, const std::string& value_title)
{
    TextTable table = {{key_title, value_title}};
    for (const auto& [key, value] : object.items()) table.push_back({key, value_text(value)});
    return table;
}

std::string markdown_table(const TextTable& table)
{
    std::string text;
    for (std::size_t i = 0; i < table.size(); ++i) {
        text += "|";
        for (std::string cell : table[i]) {
            for (std::size_t at = 0; (at = cell.find('|', at)) != std::string::npos; at += 2) cell.insert(at, "\\");
            text += " " + cell + " |";
        }
        text += "\n";
        if (i > 0) continue;
        for (std::size_t k = 0; k < table[i].size(); ++k) text += k == 0 ? "|---" : "|---:";
        text += "|\n";
    }
    return text;
}

std::string escaped(const std::string& text)
{
    std::string result;
    for (const char c : text) switch (c) {
            case '&':
                result += "&amp;";
                break;
            case '<':
                result += "&lt;";
                break;
            case '>':
                result += "&gt;";
                break;
            case '"':
                result += "&quot;";
                break;
            default:
                result += c;
        }
    return result;
}

std::string html_table(const TextTable& table)
{
    std::string text = "<table>\n";
    for (std::size_t i = 0; i < table.size(); ++i) {
        text += "<tr>";
        for (const std::string& cell : table[i])
            text += i == 0 ? "<th>" + escaped(cell) + "</th>" : "<td>" + escaped(cell) + "</td>";
        text += "</tr>\n";
    }
    return text + "</table>\n";
}

const char* const page_style = R"(
:root { color-scheme: light dark; --fg: #1d2228; --bg: #fbfbfa; --line: #cfd4da; --soft: #5c6670; }
@media (prefers-color-scheme: dark) { :root { --fg: #e4e7ea; --bg: #17191c; --line: #3a4047; --soft: #9aa4ae; } }
body { font: 16px/1.5 system-ui, sans-serif; color: var(--fg); background: var(--bg); max-width: 70rem; margin: 2rem auto;
  padding: 0 1rem; }
table { border-collapse: collapse; margin: 1rem 0; font-variant-numeric: tabular-nums; }
th, td { border-bottom: 1px solid var(--line); padding: 0.3rem 0.9rem; text-align: right; }
th:first-child, td:first-child { text-align: left; }
td:last-child { overflow-wrap: anywhere; }
.tables { display: flex; flex-wrap: wrap; gap: 0 3rem; }
figure { margin: 2rem 0; } img { max-width: 100%; height: auto; border-radius: 6px; }
figcaption, .note { color: var(--soft); }
)";

std::string averages_note(const Report& report)
{
    const TableCounts& counts = report.counts;
    std::string note =
        fmt::format("Averages over {} samples of the {} split ({} bodies, {} poses).", counts.evaluated_samples,
                    report.split, counts.evaluated_bodies, counts.evaluated_poses);
    if (counts.unconverged_samples + counts.failed_samples > 0)
        note += fmt::format(
            " Left out for all methods alike: {} samples on which FEM did not converge, {} that it failed on.",
            counts.unconverged_samples, counts.failed_samples);
    return note;
}

const char* const metric_note =
    "E_pos: mean distance of the free vertices (muscle wrap and skin) to FEM. E_grad: mean squared difference of the "
    "deformation gradients' entries. E_inv: prisms with negative exact volume in a frame. E_corner: prisms "
    "with a negative Jacobian at a corner, which the paper does not count. E_vol: mean squared relative "
    "volume change of the prisms.";
const char* const paper_note =
    "The paper's figures come from other bodies, other motions and another resolution; only the order of the methods "
    "and the rough ratios between them can be compared.";

}  // namespace

std::string tables_json(const Report& report)
{
    Json json;
    json["table1"] = Json::object();
    for (const MethodMetrics& row : report.rows)
        json["table1"][row.method] = {{"E_pos_mm", row.mean.position_error_mm},
                                      {"E_grad_e3", 1e3 * row.mean.gradient_error},
                                      {"E_inv", row.mean.inverted_prisms},
                                      {"E_corner", row.mean.corner_inverted_prisms},
                                      {"E_vol_e3", 1e3 * row.mean.volume_error}};
    json["counts"] = counts_json(report);
    json["seconds"] = parse_seconds(report.seconds_json, "The table of stage times");
    return json.dump(2) + "\n";
}

std::string results_markdown(const Report& report)
{
    const Json seconds = parse_seconds(report.seconds_json, "The table of stage times");
    std::string text = "# Results\n\n";
    text += averages_note(report) + "\n\n";
    text += "## Table 1, measured here\n\n" + markdown_table(our_table(report)) + "\n" + metric_note + "\n\n";
    text += "## Table 1 as the paper prints it (not measured here)\n\n" + markdown_table(paper_table()) + "\n" +
            paper_note + "\n\n";
    text += "## Counts\n\n" + markdown_table(object_table(counts_json(report), "Quantity", "Value"));
    if (!seconds.empty()) text += "\n## Time\n\n" + markdown_table(object_table(seconds, "Stage", "Seconds"));
    if (!report.licences.empty()) text += "\n## Data\n\n";
    for (const std::string& licence : report.licences) text += "- " + licence + "\n";
    return text;
}

std::string report_page(const Report& report, const std::vector<std::string>& pictures)
{
    const Json seconds = parse_seconds(report.seconds_json, "The table of stage times");
    std::ostringstream page;
    page << "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         << "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
         << "<title>Neural Deformation Gradients: results</title>\n<style>" << page_style
         << "</style>\n</head>\n<body>\n"
         << "<h1>Neural Deformation Gradients: results</h1>\n<p>" << averages_note(report)
         << "</p>\n<div class=\"tables\">\n<div><h2>Measured here</h2>\n"
         << html_table(our_table(report)) << "</div>\n<div><h2>As the paper prints it</h2>\n"
         << html_table(paper_table()) << "</div>\n</div>\n<p class=\"note\">" << metric_note << " " << paper_note
         << "</p>\n";
    for (const std::string& picture : pictures)
        page << "<figure><img src=\"" << escaped(picture) << "\" alt=\"" << escaped(picture) << "\"><figcaption>"
             << escaped(picture) << "</figcaption></figure>\n";
    page << "<h2>Counts</h2>\n" << html_table(object_table(counts_json(report), "Quantity", "Value"));
    if (!seconds.empty()) page << "<h2>Time</h2>\n" << html_table(object_table(seconds, "Stage", "Seconds"));
    if (!report.licences.empty()) {
        page << "<h2>Data</h2>\n<ul>\n";
        for (const std::string& licence : report.licences) page << "<li>" << escaped(licence) << "</li>\n";
        page << "</ul>\n";
    }
    page << "</body>\n</html>\n";
    return page.str();
}

void write_report(const std::string& tables_path, const Report& report)
{
    const std::filesystem::path path(tables_path);
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
    std::filesystem::create_directories(folder);
    std::vector<std::string> pictures;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.path().extension() == ".png") pictures.push_back(entry.path().filename().string());
    std::sort(pictures.begin(), pictures.end());
    write_file((folder / "results.md").string(), results_markdown(report));
    write_file((folder / "index.html").string(), report_page(report, pictures));
    write_file(path.string(), tables_json(report));  // last: its presence says that the report is whole
}

std::string read_seconds(const std::string& path)
{
    return parse_seconds(read_file(path), path).dump();
}

}  // namespace ndg
