// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/batch_report.h"

#include "ndg/core/error.h"
#include "ndg/core/json_file.h"
#include "ndg/registration/fit_report.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace ndg {
namespace {

std::string error_line(const std::string& name, const FitErrors& e)
{
    return fmt::format(
        "{}: true surface mean {:.2f}, 95 % {:.2f}, max {:.1f} mm; correspondence {:.2f} mm; joints mean {:.1f}, max "
        "{:.1f} mm ({})\n",
        name, 1e3 * e.surface_mean, 1e3 * e.surface_p95, 1e3 * e.surface_max, 1e3 * e.correspondence_mean,
        1e3 * e.joint_mean, 1e3 * e.joint_max, e.worst_joint);
}

/// Mean over the bodies and the largest value with its body, in mm.
std::string mean_and_largest(const std::map<std::string, FitErrors>& errors, double FitErrors::*figure)
{
    double sum = 0.0;
    const auto largest = std::max_element(errors.begin(), errors.end(), [&](const auto& a, const auto& b) {
        return a.second.*figure < b.second.*figure;
    });
    for (const auto& entry : errors) sum += entry.second.*figure;
    return fmt::format("{:.2f} mm, largest {:.2f} ({})", 1e3 * sum / static_cast<double>(errors.size()),
                       1e3 * (largest->second.*figure), largest->first);
}

}  // namespace

BatchReport::BatchReport(const std::vector<BatchEntry>& entries, const ScanTruth& truth,
                         const Eigen::Ref<const Triangles>& triangles)
    : scans(entries.size())
{
    std::pair<bool, double> largest = {false, -1.0};
    for (const BatchEntry& entry : entries) {
        if (!entry.failure.empty()) continue;
        ++fitted;
        passed += entry.passed();
        const std::string& name = entry.fitted.body.name;
        const TrueBody* body = truth.find(name);
        if (body != nullptr) errors[name] = measure_errors(entry.fitted, *body, triangles);
        const double distance = body != nullptr ? errors[name].surface_mean : entry.fitted.report.scan_to_skin_mean;
        // One that missed the gate is worse than any that did not.
        const std::pair<bool, double> badness = {!entry.passed(), distance};
        if (badness > largest) {
            largest = badness;
            worst = name;
        }
    }
}

std::string BatchReport::text(const std::vector<BatchEntry>& entries) const
{
    std::string result, failed;
    double seconds = 0.0;
    for (const BatchEntry& entry : entries) {
        const bool has_body = entry.failure.empty();
        result += has_body ? report_line(entry.fitted.report) + "\n" : "FAILED: " + entry.failure + "\n";
        if (has_body) seconds += entry.fitted.report.seconds;
        if (!entry.passed()) failed += (failed.empty() ? "" : ", ") + entry.name();
    }
    for (const auto& [name, e] : errors) result += error_line(name, e);
    if (!errors.empty()) {
        result += fmt::format("truth of {} bodies:\n", errors.size());
        const std::vector<std::pair<const char*, double FitErrors::*>> figures = {
            {"surface, mean distance", &FitErrors::surface_mean}, {"surface, 95 %", &FitErrors::surface_p95},
            {"surface, maximum", &FitErrors::surface_max},        {"correspondence", &FitErrors::correspondence_mean},
            {"joint centres, mean", &FitErrors::joint_mean},      {"joint centres, maximum", &FitErrors::joint_max}};
        for (const auto& [label, figure] : figures) {
            result += fmt::format("  {}: mean {}\n", label, mean_and_largest(errors, figure));
        }
    }
    if (fitted > 0) {
        result +=
            fmt::format("worst body: {}; mean time of a fit {:.1f} s\n", worst, seconds / static_cast<double>(fitted));
    }
    result += fmt::format("{} of {} scans fitted, {} pass the gate ({:.1f} %)\n", fitted, scans, passed,
                          100.0 * passed_share());
    if (!failed.empty()) result += fmt::format("not passed: {}\n", failed);
    return result;
}

std::string BatchReport::json(const std::vector<BatchEntry>& entries) const
{
    nlohmann::json reports = nlohmann::json::array();
    for (const BatchEntry& entry : entries) {
        nlohmann::json report = nlohmann::json::parse(entry.failure.empty() ? report_json(entry.fitted.report)
                                                                            : failure_json(entry.file, entry.failure));
        const auto found = errors.find(entry.fitted.body.name);
        if (entry.failure.empty() && found != errors.end()) {
            const FitErrors& e = found->second;
            report["truth_surface_mean_m"] = e.surface_mean;
            report["truth_surface_p95_m"] = e.surface_p95;
            report["truth_surface_max_m"] = e.surface_max;
            report["truth_correspondence_mean_m"] = e.correspondence_mean;
            report["truth_joint_mean_m"] = e.joint_mean;
            report["truth_joint_max_m"] = e.joint_max;
            report["truth_worst_joint"] = e.worst_joint;
        }
        reports.push_back(std::move(report));
    }
    const nlohmann::json whole = {
        {"scans", scans}, {"fitted", fitted}, {"passed", passed}, {"worst", worst}, {"reports", reports}};
    return whole.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

ReportedFit read_reported_fit(const std::string& path, const std::string& name)
{
    const JsonValue root(path);
    const std::string wanted = name.empty() ? root.at("worst").text() : name;
    for (const JsonValue& report : root.at("reports").elements()) {
        if (report.text_or("name", "") != wanted) continue;
        ReportedFit fit;
        fit.name = wanted;
        fit.file = report.at("file").text();
        fit.unit = parse_name<LengthUnit>(report.at("unit").text(), path + ": unit");
        fit.up = parse_name<Axis>(report.at("up").text(), path + ": up");
        fit.heading_degrees = report.at("heading_degrees").number();
        return fit;
    }
    throw InputError(fmt::format("{}: holds no fit of \"{}\"", path, wanted));
}

}  // namespace ndg
