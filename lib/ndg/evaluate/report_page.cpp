// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/file.h"
#include "ndg/core/markup.h"
#include "ndg/evaluate/report.h"
#include "ndg/evaluate/report_html.h"
#include "ndg/evaluate/svg_chart.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>

namespace ndg {
namespace {

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

}  // namespace

std::string report_page(const Report& report, const std::vector<std::string>& picture_paths)
{
    std::string page;
    const nlohmann::ordered_json tables = nlohmann::ordered_json::parse(tables_json(report));
    for (const ReportSection& section : report_sections(report, tables)) {
        // Pictures stand between what was measured and what it was measured on.
        if (section.title == "Counts") {
            page += html_figure(distribution_chart(report.rows), "E_pos of the samples, sorted, of each method.");
            page +=
                html_figure(volume_chart(report.rows), "Change of volume of the prisms by each method (NDG Figure 9).");
            for (const std::string& path : picture_paths) {
                const std::string name = std::filesystem::path(path).filename().string();
                page += html_figure(html_picture(read_file(path), name), name);
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
    return html_report("Neural Deformation Gradients: results", page);
}

}  // namespace ndg
