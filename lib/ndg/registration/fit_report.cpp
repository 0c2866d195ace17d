// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/fit_report.h"

#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ndg {
namespace {

constexpr int num_worst = 5;

struct Distances {
    double mean = 0.0, p95 = 0.0, max = 0.0;
};

Distances summarise(std::vector<double> values)
{
    Distances result;
    if (values.empty()) return result;
    std::sort(values.begin(), values.end());
    for (const double value : values) result.mean += value / static_cast<double>(values.size());
    result.p95 = values[0.95 * static_cast<double>(values.size() - 1)];
    result.max = values.back();
    return result;
}

void measure_scan_to_skin(const Eigen::Ref<const Points>& skin, const Eigen::Ref<const Triangles>& triangles,
                          const ScanTarget& scan, double covered, FitReport& report)
{
    const TriangleTree tree(skin, triangles);
    std::vector<double> distances(scan.points.rows());
#pragma omp parallel for schedule(dynamic, 256)
    for (std::size_t i = 0; i < distances.size(); ++i) {
        distances[i] = tree.closest(scan.points.row(static_cast<Eigen::Index>(i)).transpose()).distance;
    }
    report.scan_to_skin_max = *std::max_element(distances.begin(), distances.end());
    const auto end = std::remove_if(distances.begin(), distances.end(), [&](double d) { return d > covered; });
    report.coverage = static_cast<double>(end - distances.begin()) / static_cast<double>(distances.size());
    distances.erase(end, distances.end());
    const Distances summary = summarise(std::move(distances));
    report.scan_to_skin_mean = summary.mean;
    report.scan_to_skin_p95 = summary.p95;
}

void measure_skin_to_scan(const Eigen::Ref<const Points>& skin, const Eigen::Ref<const Triangles>& triangles,
                          const ScanTarget& scan, double covered, FitReport& report)
{
    std::vector<int> rows(skin.rows());
    std::iota(rows.begin(), rows.end(), 0);
    const Eigen::VectorXd areas = vertex_areas(skin, triangles);
    std::vector<double> distances;
    double seen = 0.0;
    for (const PlaneMatch& match :
         match_surface_to_scan(skin, vertex_normals(skin, triangles), rows, scan, 2.0 * covered)) {
        distances.push_back(std::abs(match.residual));
        if (distances.back() <= covered) seen += areas[match.vertex];
    }
    report.seen = seen / areas.sum();
    const Distances summary = summarise(std::move(distances));
    report.skin_to_scan_mean = summary.mean;
    report.skin_to_scan_p95 = summary.p95;
    report.skin_to_scan_max = summary.max;
}

void measure_triangles(const Eigen::Ref<const Points>& rest_skin, const Eigen::Ref<const Points>& rest_template,
                       const Eigen::Ref<const Triangles>& triangles, FitReport& report)
{
    const Points normals = triangle_normals(rest_skin, triangles);
    const Points expected = triangle_normals(rest_template, triangles);
    const Eigen::VectorXd ratios =
        triangle_areas(rest_skin, triangles).cwiseQuotient(triangle_areas(rest_template, triangles).cwiseMax(1e-12));
    report.flipped_triangles = static_cast<int>(((normals.cwiseProduct(expected)).rowwise().sum().array() < 0).count());
    std::vector<int> order(triangles.rows());
    std::iota(order.begin(), order.end(), 0);
    const auto worst = std::min<std::size_t>(num_worst, order.size());
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(worst), order.end(),
                      [&](int a, int b) { return ratios[a] != ratios[b] ? ratios[a] < ratios[b] : a < b; });
    order.resize(worst);
    report.worst_triangles = order;
    report.smallest_area_ratio = ratios[order.front()];
}

}  // namespace

void measure_fit(const Eigen::Ref<const Points>& posed_skin, const Eigen::Ref<const Points>& rest_skin,
                 const Eigen::Ref<const Points>& rest_template, const Eigen::Ref<const Triangles>& triangles,
                 const ScanTarget& scan, const FitOptions& options, FitReport& report)
{
    measure_scan_to_skin(posed_skin, triangles, scan, options.covered, report);
    measure_skin_to_scan(posed_skin, triangles, scan, options.covered, report);
    measure_triangles(rest_skin, rest_template, triangles, report);
    report.stature = rest_skin.col(1).maxCoeff() - rest_skin.col(1).minCoeff();
    report.points = static_cast<std::size_t>(scan.points.rows());
    report.defects.clear();
    if (!(report.scan_to_skin_mean <= options.max_mean)) {
        report.defects.push_back(fmt::format("mean distance {:.1f} mm is over {:.1f} mm",
                                             1e3 * report.scan_to_skin_mean, 1e3 * options.max_mean));
    }
    if (!(report.coverage >= options.min_coverage)) {
        report.defects.push_back(fmt::format("only {:.0f} % of the scan lies near the skin, {:.0f} % are needed",
                                             100 * report.coverage, 100 * options.min_coverage));
    }
    if (!(report.seen >= options.min_seen)) {
        report.defects.push_back(fmt::format("the scan shows only {:.0f} % of the skin, {:.0f} % are needed",
                                             100 * report.seen, 100 * options.min_seen));
    }
    if (!(report.stature >= options.min_stature && report.stature <= options.max_stature)) {
        report.defects.push_back(fmt::format("a stature of {:.2f} m is not one from {:.2f} to {:.2f} m", report.stature,
                                             options.min_stature, options.max_stature));
    }
    if (report.flipped_triangles > options.max_flipped * static_cast<double>(triangles.rows())) {
        report.defects.push_back(fmt::format("{} triangles are flipped", report.flipped_triangles));
    }
}

std::string report_line(const FitReport& r)
{
    std::string line = fmt::format(
        "{}: scan to skin mean {:.2f}, 95 % {:.2f}, max {:.1f} mm; skin to scan {:.2f}, {:.2f}, {:.1f} mm; scan "
        "covered "
        "{:.1f} %, skin seen {:.1f} %; stature {:.3f} m; {} flipped triangles; unit {}{}, up {}{}; {:.1f} s",
        r.name, 1e3 * r.scan_to_skin_mean, 1e3 * r.scan_to_skin_p95, 1e3 * r.scan_to_skin_max,
        1e3 * r.skin_to_scan_mean, 1e3 * r.skin_to_scan_p95, 1e3 * r.skin_to_scan_max, 100 * r.coverage, 100 * r.seen,
        r.stature, r.flipped_triangles, r.unit, r.unit_guessed ? " (guessed)" : "", r.up,
        r.up_guessed ? " (guessed)" : "", r.seconds);
    for (const std::string& defect : r.defects) line += "; FAILED: " + defect;
    return line;
}

std::string report_json(const FitReport& r)
{
    return nlohmann::json{{"name", r.name},
                          {"file", r.file},
                          {"unit", r.unit},
                          {"unit_guessed", r.unit_guessed},
                          {"up", r.up},
                          {"up_guessed", r.up_guessed},
                          {"heading_degrees", r.heading_degrees},
                          {"file_points", r.file_points},
                          {"points", r.points},
                          {"scan_to_skin_mean_m", r.scan_to_skin_mean},
                          {"scan_to_skin_p95_m", r.scan_to_skin_p95},
                          {"scan_to_skin_max_m", r.scan_to_skin_max},
                          {"skin_to_scan_mean_m", r.skin_to_scan_mean},
                          {"skin_to_scan_p95_m", r.skin_to_scan_p95},
                          {"skin_to_scan_max_m", r.skin_to_scan_max},
                          {"coverage", r.coverage},
                          {"seen", r.seen},
                          {"stature_m", r.stature},
                          {"flipped_triangles", r.flipped_triangles},
                          {"smallest_area_ratio", r.smallest_area_ratio},
                          {"worst_triangles", r.worst_triangles},
                          {"seconds", r.seconds},
                          {"defects", r.defects}}
        .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string failure_json(const std::string& file, const std::string& failure)
{
    // File names need not be UTF-8.
    return nlohmann::json{{"file", file}, {"failure", failure}}.dump(-1, ' ', false,
                                                                     nlohmann::json::error_handler_t::replace);
}

}  // namespace ndg
