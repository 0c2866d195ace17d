// SPDX-License-Identifier: Apache-2.0
#include "ndg/evaluate/paper_values.h"
#include "ndg/evaluate/report.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <array>
#include <cmath>

namespace ndg {
namespace {

using Json = nlohmann::ordered_json;
using TextTable = std::vector<std::vector<std::string>>;

struct Measure {
    const char* key;
    const char* title;
    int digits;
    double PaperRow::*paper;  ///< null where the paper has no such measure
};
const std::array<Measure, 5> measures = {{{"E_pos_mm", "E_pos [mm]", 3, &PaperRow::position_mm},
                                          {"E_grad_e3", "E_grad [1e-3]", 3, &PaperRow::gradient_e3},
                                          {"E_inv", "E_inv", 2, &PaperRow::inverted},
                                          {"E_corner", "E_corner", 2, nullptr},
                                          {"E_vol_e3", "E_vol [1e-3]", 3, &PaperRow::volume_e3}}};

std::string figure(double value, int digits)
{
    return std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : "-";
}

const PaperRow* find_row(const std::vector<PaperRow>& rows, const std::string& method)
{
    for (const PaperRow& row : rows)
        if (row.method == method) return &row;
    return nullptr;
}

/// Figures of the methods with the paper's in brackets.
TextTable figures_table(const Json& table, const std::vector<PaperRow>& paper)
{
    TextTable text = {{"Method"}};
    for (const Measure& measure : measures) text[0].emplace_back(measure.title);
    text[0].emplace_back("What it is");
    for (const auto& [method, figures] : table.items()) {
        const PaperRow* row = find_row(paper, method);
        std::vector<std::string> line = {method};
        for (const Measure& measure : measures) {
            line.push_back(figure(figures[measure.key].get<double>(), measure.digits));
            if (row && measure.paper && std::isfinite(row->*measure.paper))
                line.back() += fmt::format(" ({:.2f})", row->*measure.paper);
        }
        line.push_back(method_in_words(method));
        text.push_back(line);
    }
    return text;
}

/// Every method's measures over NDG's, with the paper's ratios in brackets; no lines where NDG has no row.
TextTable ratio_table(const Json& table, const std::vector<PaperRow>& paper)
{
    TextTable text = {{"Method over NDG", "E_pos", "E_grad", "E_inv", "E_vol"}};
    const PaperRow* paper_ndg = find_row(paper, "NDG");
    if (!table.contains("NDG")) return text;
    for (const auto& [method, figures] : table.items()) {
        if (method == "NDG") continue;
        const PaperRow* row = find_row(paper, method);
        std::vector<std::string> line = {method};
        for (const Measure& measure : measures) {
            if (!measure.paper) continue;
            line.push_back(figure(figures[measure.key].get<double>() / table["NDG"][measure.key].get<double>(), 2));
            if (row && paper_ndg && std::isfinite(row->*measure.paper))
                line.back() += fmt::format(" ({:.2f})", row->*measure.paper / (paper_ndg->*measure.paper));
        }
        text.push_back(line);
    }
    return text;
}

TextTable protrusion_table(const Json& table)
{
    TextTable text = {{"Method", "Frames with intersection [%]", "Frames with protrusion [%]", "Mean protrusion [mm]",
                       "Largest [mm]", "Frames", "Deepest"}};
    for (const auto& [method, row] : table.items())
        text.push_back({method, figure(row["intersecting_frames"], 1), figure(row["protruding_frames"], 1),
                        figure(row["protrusion_mm"], 2), figure(row["max_protrusion_mm"], 1), row["frames"].dump(),
                        row["deepest"]});
    for (const PaperProtrusion& row : paper_protrusion())
        text.push_back({fmt::format("{} (the paper's)", row.method), figure(row.intersecting_frames, 1),
                        figure(row.protruding_frames, 1), figure(row.protrusion_mm, 1), "-", "500", ""});
    return text;
}

TextTable spread_table(const Json& table1, const Json& spread)
{
    TextTable text = {{"Method", "E_pos [mm]", "+- over bodies", "+- over poses", "median", "90 %", "largest",
                       "E_vol [1e-3] +- over bodies", "+- over poses"}};
    for (const auto& [method, row] : spread.items()) {
        if (!table1.contains(method)) continue;
        const auto value = [&, &figures = row](const char* key) { return figure(figures[key].get<double>(), 3); };
        text.push_back({method, figure(table1[method]["E_pos_mm"], 3), value("E_pos_mm_over_bodies"),
                        value("E_pos_mm_over_poses"), value("E_pos_mm_median"), value("E_pos_mm_90_percent"),
                        value("E_pos_mm_largest"), value("E_vol_e3_over_bodies"), value("E_vol_e3_over_poses")});
    }
    return text;
}

TextTable object_table(const Json& object, const std::string& key_title, const std::string& value_title)
{
    TextTable table = {{key_title, value_title}};
    for (const auto& [key, value] : object.items())
        table.push_back({key, value.is_string() ? value.get<std::string>() : value.dump()});
    return table;
}

const char* const metric_legend =
    "E_pos: mean distance of the free vertices (muscle wrap and skin) to FEM. E_grad: mean squared difference of the "
    "deformation gradients' entries. E_inv: prisms with negative exact volume in a frame. E_corner: prisms "
    "with a negative Jacobian at a corner, which the paper does not count. E_vol: mean squared relative "
    "volume change of the prisms.";

std::string averages_note(const Report& report)
{
    const TableCounts& counts = report.counts;
    std::string note = fmt::format(
        "Averages over {} samples of the {} split ({} bodies, {} poses). In brackets: as the paper prints "
        "it, not measured here.",
        counts.evaluated_samples, report.split, counts.evaluated_bodies, counts.evaluated_poses);
    if (counts.unconverged_samples + counts.failed_samples > 0)
        note += fmt::format(
            " Left out for all methods alike: {} samples on which FEM did not converge, {} that it failed on.",
            counts.unconverged_samples, counts.failed_samples);
    return note;
}

}  // namespace

std::vector<ReportSection> report_sections(const Report& report, const Json& tables)
{
    std::vector<ReportSection> sections;
    const Json& table1 = tables["table1"];
    sections.push_back({"Table 1: methods against FEM", averages_note(report),
                        figures_table(table1, paper_rows("table1")), metric_legend});
    sections.push_back({"Table 1: ratios", "Measures over those of NDG, the paper's ratios in brackets.",
                        ratio_table(table1, paper_rows("table1")),
                        "The paper's figures come from other bodies, other motions and another resolution; only the "
                        "order of the methods and the rough ratios between them can be compared."});
    if (tables.contains("table2"))
        sections.push_back({"Table 2: a body outside the training distribution", "",
                            figures_table(tables["table2"], paper_rows("table2")), ""});
    if (tables.contains("table3"))
        sections.push_back(
            {"Table 3: bones and muscles against the skin",
             fmt::format(
                 "{} pairs of body and pose, {} of them left out because coarse parts of the body collide; head, "
                 "hands and toes do not count. At rest anatomy crosses the skin of {} of {} bodies.",
                 tables["counts"].value("table3_pairs", 0), tables["counts"].value("table3_colliding_pairs", 0),
                 tables["counts"].value("table3_bodies_intersecting_at_rest", 0),
                 tables["counts"].value("table3_bodies", 0)),
             protrusion_table(tables["table3"]),
             "Mean protrusion: distance to the skin of all vertices outside of it in all frames."});
    if (tables.contains("table4")) {
        sections.push_back({"Table 4: variants of NDG", "", figures_table(tables["table4"], paper_rows("table4")), ""});
        sections.push_back({"Table 4: ratios", "", ratio_table(tables["table4"], paper_rows("table4")), ""});
    }
    if (tables.contains("beyond_paper"))
        sections.push_back({"Beyond the paper", "", figures_table(tables["beyond_paper"], {}), ""});
    sections.push_back({"Spread over bodies, poses and samples",
                        "Standard deviations of the means of bodies and of poses; quantiles of the samples.",
                        spread_table(table1, tables["spread"]), ""});
    sections.push_back({"Counts", "", object_table(tables["counts"], "Quantity", "Value"), ""});
    if (!tables["seconds"].empty())
        sections.push_back({"Time", "", object_table(tables["seconds"], "Stage", "Seconds"), ""});
    TextTable provenance = {{"What", "Which"}, {"commit", tables["commit"]}, {"command", tables["command"]}};
    for (const Provenance::Input& input : report.inputs) provenance.push_back({input.path, "SHA-256 " + input.sha256});
    sections.push_back({"Provenance", "", provenance, ""});
    return sections;
}

}  // namespace ndg
