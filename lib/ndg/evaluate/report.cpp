// SPDX-License-Identifier: Apache-2.0
#include "ndg/evaluate/report.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

namespace ndg {
namespace {

using Json = nlohmann::ordered_json;

Json parse_seconds(const std::string& text, const std::string& source)
{
    Json seconds = Json::parse(text, nullptr, false);
    require_input(!seconds.is_discarded() && seconds.is_object(), "{} is not a JSON object of seconds", source);
    for (const auto& [stage, value] : seconds.items())
        require_input(value.is_number(), "{}: the seconds of stage \"{}\" are not a number", source, stage);
    return seconds;
}

/// An object of a JSON file that holds objects under `keys`.
Json read_tables(const std::string& path, const std::vector<std::string>& keys)
{
    Json json = Json::parse(read_file(path), nullptr, false);
    require_input(!json.is_discarded() && json.is_object(), "{} is not a JSON object", path);
    for (const std::string& key : keys)
        require_input(json.contains(key) && json[key].is_object(), "{} has no {}", path, key);
    return json;
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

Json figures_json(const SampleMetrics& metrics)
{
    return {{"E_pos_mm", metrics.position_error_mm},
            {"E_grad_e3", 1e3 * metrics.gradient_error},
            {"E_inv", metrics.inverted_prisms},
            {"E_corner", metrics.corner_inverted_prisms},
            {"E_vol_e3", 1e3 * metrics.volume_error}};
}

/// Standard deviation of the means over groups of samples (n - 1 in the denominator); 0 for one group.
double spread_of_means(const MethodMetrics& row, int SamplePair::*group, double SampleMetrics::*measure)
{
    std::map<int, std::pair<double, int>> sums;
    for (std::size_t i = 0; i < row.samples.size(); ++i) {
        auto& [sum, count] = sums[row.pairs[i].*group];
        sum += row.samples[i].*measure;
        ++count;
    }
    if (sums.size() < 2) return 0.0;
    double mean = 0.0, squares = 0.0;
    for (const auto& [key, sum] : sums) mean += sum.first / sum.second / double(sums.size());
    for (const auto& [key, sum] : sums) squares += std::pow(sum.first / sum.second - mean, 2);
    return std::sqrt(squares / double(sums.size() - 1));
}

/// How E_pos and E_vol differ between bodies, between poses and between samples.
Json spread_json(const MethodMetrics& row)
{
    std::vector<double> sorted;
    for (const SampleMetrics& sample : row.samples) sorted.push_back(sample.position_error_mm);
    std::sort(sorted.begin(), sorted.end());
    const auto quantile = [&](double share) { return sorted[std::size_t(share * double(sorted.size() - 1))]; };
    return {{"E_pos_mm_over_bodies", spread_of_means(row, &SamplePair::body_idx, &SampleMetrics::position_error_mm)},
            {"E_pos_mm_over_poses", spread_of_means(row, &SamplePair::pose_idx, &SampleMetrics::position_error_mm)},
            {"E_vol_e3_over_bodies", 1e3 * spread_of_means(row, &SamplePair::body_idx, &SampleMetrics::volume_error)},
            {"E_vol_e3_over_poses", 1e3 * spread_of_means(row, &SamplePair::pose_idx, &SampleMetrics::volume_error)},
            {"E_pos_mm_median", quantile(0.5)},
            {"E_pos_mm_90_percent", quantile(0.9)},
            {"E_pos_mm_largest", sorted.back()}};
}

Json all_tables(const Report& report)
{
    Json json, spread = Json::object();
    json["table1"] = Json::object();
    for (const MethodMetrics& row : report.rows) json["table1"][row.method] = figures_json(row.mean);
    Json counts = counts_json(report);
    if (!report.unseen_path.empty()) {
        const Json unseen = read_tables(report.unseen_path, {"table1", "counts"});
        json["table2"] = unseen["table1"];
        for (const char* name : {"test_samples", "test_left_out_unconverged", "test_left_out_failed"})
            if (unseen["counts"].contains(name)) counts[std::string("table2_") + name] = unseen["counts"][name];
    }
    if (!report.protrusion_path.empty()) {
        const Json protrusion = read_tables(report.protrusion_path, {"table3", "counts"});
        json["table3"] = protrusion["table3"];
        counts.update(protrusion["counts"]);
    }
    if (!report.variants.empty()) {
        if (json["table1"].contains("NDG")) json["table4"]["NDG"] = json["table1"]["NDG"];
        for (const MethodMetrics& row : report.variants) json["table4"][row.method] = figures_json(row.mean);
    }
    for (const MethodMetrics& row : report.beyond_paper) json["beyond_paper"][row.method] = figures_json(row.mean);
    for (const auto* rows : {&report.rows, &report.variants, &report.beyond_paper})
        for (const MethodMetrics& row : *rows) spread[row.method] = spread_json(row);
    json["spread"] = spread;
    json["counts"] = counts;
    json["seconds"] = parse_seconds(report.seconds_json, "The table of stage times");
    json["commit"] = project_commit();
    json["command"] = report.command;
    return json;
}

std::string markdown_table(const std::vector<std::vector<std::string>>& table)
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

}  // namespace

std::string tables_json(const Report& report)
{
    return all_tables(report).dump(2) + "\n";
}

std::string results_markdown(const Report& report)
{
    std::string text = "# Results\n";
    for (const ReportSection& section : report_sections(report, all_tables(report))) {
        text += "\n## " + section.title + "\n\n";
        if (!section.note.empty()) text += section.note + "\n\n";
        text += markdown_table(section.table);
        if (!section.legend.empty()) text += "\n" + section.legend + "\n";
    }
    if (!report.licences.empty()) text += "\n## Data\n\n";
    for (const std::string& licence : report.licences) text += "- " + licence + "\n";
    return text;
}

void write_report(const std::string& tables_path, const Report& report)
{
    const std::filesystem::path path(tables_path);
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
    std::filesystem::create_directories(folder);
    std::vector<std::string> pictures;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.path().extension() == ".png") pictures.push_back(entry.path().string());
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
