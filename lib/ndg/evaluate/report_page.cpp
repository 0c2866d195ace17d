// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/file.h"
#include "ndg/core/markup.h"
#include "ndg/evaluate/report.h"
#include "ndg/evaluate/svg_chart.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdint>
#include <filesystem>

namespace ndg {
namespace {

std::string html_table(const std::vector<std::vector<std::string>>& table)
{
    std::string text = "<div class=\"wide\"><table>\n";
    for (std::size_t i = 0; i < table.size(); ++i) {
        text += "<tr>";
        for (const std::string& cell : table[i])
            text += i == 0 ? "<th>" + escaped_markup(cell) + "</th>" : "<td>" + escaped_markup(cell) + "</td>";
        text += "</tr>\n";
    }
    return text + "</table></div>\n";
}

/// RFC 4648.
std::string base64(const std::string& bytes)
{
    static const char* const letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t group = 0;
        const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
        for (std::size_t k = 0; k < 3; ++k)
            group = group << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k) text += k <= count ? letters[group >> (18 - 6 * k) & 63] : '=';
    }
    return text;
}

/// Largest E_pos of so many per cent of the samples, a line a method.
std::string distribution_chart(const std::vector<MethodMetrics>& rows)
{
    std::vector<SvgLine> lines;
    for (const MethodMetrics& row : rows) {
        std::vector<double> sorted;
        for (const SampleMetrics& sample : row.samples) sorted.push_back(sample.position_error_mm);
        std::sort(sorted.begin(), sorted.end());
        lines.push_back({row.method, {}});
        for (std::size_t i = 0; i < sorted.size(); ++i)
            lines.back().points.emplace_back(100.0 * double(i + 1) / double(sorted.size()), sorted[i]);
    }
    return svg_chart(lines, 0, 100, "share of samples [%]", "E_pos up to [mm]");
}

/// Share of prisms by their change of volume, a line a method (NDG Figure 9).
std::string volume_chart(const std::vector<MethodMetrics>& rows)
{
    std::vector<SvgLine> lines;
    for (const MethodMetrics& row : rows) {
        lines.push_back({row.method, {}});
        for (int bin = 0; bin < volume_bins; ++bin)
            lines.back().points.emplace_back(volume_bin_centre(bin), 100.0 * row.mean.volume_changes[bin]);
    }
    return svg_chart(lines, -1, 1, "V / V at rest - 1 (both ends: and beyond)", "share of prisms [%]");
}

const char* const page_style = R"(
:root { color-scheme: light dark; --fg: #1d2228; --bg: #fbfbfa; --line: #cfd4da; --soft: #5c6670; }
@media (prefers-color-scheme: dark) { :root { --fg: #e4e7ea; --bg: #17191c; --line: #3a4047; --soft: #9aa4ae; } }
body { font: 16px/1.5 system-ui, sans-serif; color: var(--fg); background: var(--bg); max-width: 76rem; margin: 2rem auto;
  padding: 0 1rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; margin: 1rem 0; font-variant-numeric: tabular-nums; font-size: 0.92rem; }
th, td { border-bottom: 1px solid var(--line); padding: 0.3rem 0.8rem; text-align: right; vertical-align: top; }
th:first-child, td:first-child { text-align: left; white-space: nowrap; }
td:last-child { overflow-wrap: anywhere; }
figure { margin: 2rem 0; } img, svg { max-width: 100%; height: auto; border-radius: 6px; }
svg { width: 52rem; } svg text { font-size: 12px; fill: currentColor; }
.grid { stroke: var(--line); } .line { fill: none; stroke-width: 1.8; }
figcaption, .note { color: var(--soft); max-width: 60rem; }
)";

}  // namespace

std::string report_page(const Report& report, const std::vector<std::string>& picture_paths)
{
    std::string page =
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
        "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
        "<title>Neural Deformation Gradients: results</title>\n<style>" +
        std::string(page_style) + "</style>\n</head>\n<body>\n<h1>Neural Deformation Gradients: results</h1>\n";
    const auto figure = [&](const std::string& content, const std::string& caption) {
        if (!content.empty())
            page += "<figure>" + content + "<figcaption>" + escaped_markup(caption) + "</figcaption></figure>\n";
    };
    const nlohmann::ordered_json tables = nlohmann::ordered_json::parse(tables_json(report));
    for (const ReportSection& section : report_sections(report, tables)) {
        // Pictures stand between what was measured and what it was measured on.
        if (section.title == "Counts") {
            figure(distribution_chart(report.rows), "E_pos of the samples, sorted, of each method.");
            figure(volume_chart(report.rows), "Change of volume of the prisms by each method (NDG Figure 9).");
            for (const std::string& path : picture_paths) {
                const std::string name = std::filesystem::path(path).filename().string();
                figure("<img src=\"data:image/png;base64," + base64(read_file(path)) + "\" alt=\"" +
                           escaped_markup(name) + "\">",
                       name);
            }
        }
        page += "<h2>" + escaped_markup(section.title) + "</h2>\n";
        if (!section.note.empty()) page += "<p class=\"note\">" + escaped_markup(section.note) + "</p>\n";
        page += html_table(section.table);
        if (!section.legend.empty()) page += "<p class=\"note\">" + escaped_markup(section.legend) + "</p>\n";
    }
    if (!report.licences.empty()) {
        page += "<h2>Data</h2>\n<ul>\n";
        for (const std::string& licence : report.licences) page += "<li>" + escaped_markup(licence) + "</li>\n";
        page += "</ul>\n";
    }
    return page + "</body>\n</html>\n";
}

}  // namespace ndg
