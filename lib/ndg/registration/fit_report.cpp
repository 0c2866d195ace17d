// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/fit_report.h"

#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace ndg {
namespace {

constexpr int num_worst = 5;
/// Clothes, shoes and hair lie this near to the skin, m.
constexpr double cover_reach = 0.08;
/// Share of a segment's area from which on it counts as covered.
constexpr double least_covered = 0.1;
/// Hands and feet show less of themselves: soles, and what lies between fingers.
constexpr double extremity_share = 0.6;
/// By how much shoes and hair make a scan higher than its person, m.
constexpr double cover_height = 0.06;
/// A head is 0.13 of an adult's stature (Drillis and Contini 1966), 0.16 of a child's of eight (six and a half heads);
/// people shorter than this, m, with a head this many times an adult's share are children.
constexpr double child_stature = 1.5, child_head = 1.15;

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

/// Segments of the skin and where it is bare.
struct SkinMap {
    std::vector<SkinSegment> segments;
    const std::vector<char>& covered;
};

void measure_scan_to_skin(const Points& skin, const Triangles& triangles, const SkinMap& map, const ScanTarget& scan,
                          double near, FitReport& report)
{
    const TriangleTree tree(skin, triangles);
    std::vector<double> distances(scan.points.rows());
    std::vector<int> vertices(distances.size());
#pragma omp parallel for schedule(dynamic, 256)
    for (std::size_t i = 0; i < distances.size(); ++i) {
        const ClosestPoint closest = tree.closest(scan.points.row(static_cast<Eigen::Index>(i)).transpose());
        Eigen::Index corner = 0;
        closest.barycentric.maxCoeff(&corner);
        distances[i] = closest.distance;
        vertices[i] = triangles(closest.triangle_idx, corner);
    }
    std::vector<double> near_ones;
    std::array<double, num_skin_segments> count{}, total{}, sum{};
    std::size_t bare = 0;
    for (std::size_t i = 0; i < distances.size(); ++i) {
        if (map.covered[vertices[i]] && distances[i] < cover_reach) continue;
        const auto segment = static_cast<std::size_t>(map.segments[vertices[i]]);
        ++bare;
        ++total[segment];
        report.scan_to_skin_max = std::max(report.scan_to_skin_max, distances[i]);
        if (distances[i] > near) continue;
        ++count[segment];
        sum[segment] += distances[i];
        near_ones.push_back(distances[i]);
    }
    report.coverage = static_cast<double>(near_ones.size()) / static_cast<double>(std::max<std::size_t>(bare, 1));
    const Distances summary = summarise(std::move(near_ones));
    report.scan_to_skin_mean = summary.mean;
    report.scan_to_skin_p95 = summary.p95;
    for (std::size_t s = 0; s < total.size(); ++s) {
        // A segment that the scan shows nothing of is found out by what is seen of it.
        report.segments[s].coverage = total[s] > 0 ? count[s] / total[s] : 1.0;
        report.segments[s].mean = count[s] > 0 ? sum[s] / count[s] : 0.0;
    }
}

void measure_skin_to_scan(const Points& skin, const Triangles& triangles, const SkinMap& map, const ScanTarget& scan,
                          double near, FitReport& report)
{
    std::vector<int> rows(skin.rows());
    std::iota(rows.begin(), rows.end(), 0);
    const Eigen::VectorXd areas = vertex_areas(skin, triangles);
    std::array<double, num_skin_segments> whole{}, bare{}, seen{};
    for (const int v : rows) {
        const auto segment = static_cast<std::size_t>(map.segments[v]);
        whole[segment] += areas[v];
        if (!map.covered[v]) bare[segment] += areas[v];
    }
    std::vector<double> distances;
    for (const PlaneMatch& match :
         match_surface_to_scan(skin, vertex_normals(skin, triangles), rows, scan, 2.0 * near)) {
        if (map.covered[match.vertex]) continue;
        distances.push_back(std::abs(match.residual));
        if (distances.back() <= near) seen[static_cast<std::size_t>(map.segments[match.vertex])] += areas[match.vertex];
    }
    double all_seen = 0.0, all_bare = 0.0;
    for (std::size_t s = 0; s < whole.size(); ++s) {
        all_seen += seen[s];
        all_bare += bare[s];
        report.segments[s].seen = bare[s] > 0 ? seen[s] / bare[s] : 1.0;
        report.segments[s].covered = whole[s] > 0 ? 1.0 - bare[s] / whole[s] : 0.0;
    }
    report.seen = all_bare > 0 ? all_seen / all_bare : 0.0;
    const Distances summary = summarise(std::move(distances));
    report.skin_to_scan_mean = summary.mean;
    report.skin_to_scan_p95 = summary.p95;
    report.skin_to_scan_max = summary.max;
}

/// Heights in the scan's pose; the soles stand on the floor where there is one.
void measure_heights(const Points& skin, const ScanTarget& scan, std::optional<double> floor, FitReport& report)
{
    report.fit_height = skin.col(1).maxCoeff() - skin.col(1).minCoeff();
    std::vector<double> heights(scan.points.col(1).begin(), scan.points.col(1).end());
    const auto rank = static_cast<std::ptrdiff_t>(heights.size() / 1000);
    std::nth_element(heights.begin(), heights.begin() + rank, heights.end());
    const double low = heights[rank];
    std::nth_element(heights.begin(), heights.end() - 1 - rank, heights.end());
    report.scan_height = *(heights.end() - 1 - rank) - floor.value_or(low);
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

bool is_pair(std::size_t segment, SegmentPair pair)
{
    return pair_of(static_cast<SkinSegment>(segment)) == pair;
}

void warn_of_covers(FitReport& report)
{
    std::vector<std::string> clothed, haired, closed;
    for (std::size_t s = 0; s < report.segments.size(); ++s) {
        if (report.segments[s].covered < least_covered) continue;
        const std::string& name = report.segments[s].name;
        (is_pair(s, SegmentPair::head) ? haired : is_pair(s, SegmentPair::hands) ? closed : clothed).push_back(name);
    }
    if (!clothed.empty()) {
        report.warnings.push_back(
            fmt::format("clothes or shoes on {}: the fit does not follow them", fmt::join(clothed, ", ")));
    }
    if (!haired.empty()) report.warnings.push_back("hair or a hat on the head: the fit does not follow it");
    if (!closed.empty()) {
        report.warnings.push_back(
            fmt::format("{} not open like the template's: the hand keeps its shape", fmt::join(closed, ", ")));
    }
}

void check_segments(const FitOptions& options, FitReport& report)
{
    std::vector<std::string> unseen, uncovered, far;
    for (std::size_t s = 0; s < report.segments.size(); ++s) {
        const SegmentReport& segment = report.segments[s];
        if (segment.covered > 1.0 - least_covered) continue;
        const bool extremity = is_pair(s, SegmentPair::hands) || is_pair(s, SegmentPair::feet);
        if (segment.seen < options.min_segment_seen * (extremity ? extremity_share : 1.0)) {
            unseen.push_back(fmt::format("{} ({:.0f} %)", segment.name, 100 * segment.seen));
        }
        if (segment.coverage < options.min_segment_coverage) {
            uncovered.push_back(fmt::format("{} ({:.0f} %)", segment.name, 100 * segment.coverage));
        }
        if (segment.mean > options.max_segment_mean) {
            far.push_back(fmt::format("{} ({:.1f} mm)", segment.name, 1e3 * segment.mean));
        }
    }
    if (!unseen.empty()) {
        report.defects.push_back(fmt::format("the scan shows too little of {}", fmt::join(unseen, ", ")));
    }
    if (!uncovered.empty()) {
        report.defects.push_back(
            fmt::format("too little of the scan lies near the skin at {}", fmt::join(uncovered, ", ")));
    }
    if (!far.empty()) report.defects.push_back(fmt::format("too far from the scan at {}", fmt::join(far, ", ")));
}

void check_size(const Points& rest_joints, const Points& rest, const SkinnedSurface& skin, const FitOptions& options,
                FitReport& report)
{
    const Skeleton& skeleton = standard_skeleton();
    const double taller = report.fit_height - report.scan_height;
    const bool may_be_shorter = std::any_of(report.segments.begin(), report.segments.end(),
                                            [&](const auto& segment) { return segment.covered >= least_covered; });
    if (taller > options.max_taller || -taller > options.max_shorter + (may_be_shorter ? cover_height : 0.0)) {
        report.defects.push_back(
            fmt::format("the fit stands {:.3f} m high, the scan {:.3f} m", report.fit_height, report.scan_height));
    }
    if (!(report.stature >= options.min_stature && report.stature <= options.max_stature)) {
        report.defects.push_back(fmt::format("a stature of {:.2f} m is not one from {:.2f} to {:.2f} m", report.stature,
                                             options.min_stature, options.max_stature));
    }
    const auto head_share = [&](const Points& vertices, const Points& joints) {
        const double top = vertices.col(1).maxCoeff(), low = vertices.col(1).minCoeff();
        return (top - joints(skeleton.joint("head"), 1)) / (top - low);
    };
    const double head = head_share(rest, rest_joints) / head_share(skin.vertices, skin.joint_positions);
    if (report.stature < child_stature && head > child_head) {
        report.defects.push_back(
            fmt::format("a stature of {:.2f} m with a head {:.2f} times an adult's share of it is a child's: what is "
                        "known of fat and muscle here is of adults",
                        report.stature, head));
    }
    report.shoulder_breadth =
        (rest_joints.row(skeleton.joint("left_upper_arm")) - rest_joints.row(skeleton.joint("right_upper_arm"))).norm();
    const double share = report.shoulder_breadth / report.stature;
    if (!(share >= options.min_shoulder_breadth && share <= options.max_shoulder_breadth)) {
        report.defects.push_back(fmt::format("the shoulder joints lie {:.3f} of the stature apart, not {} to {}", share,
                                             options.min_shoulder_breadth, options.max_shoulder_breadth));
    }
}

}  // namespace

void measure_fit(const FittedSkin& fitted, const SkinnedSurface& skin, const ScanTarget& scan,
                 std::optional<double> floor, const FitOptions& options, FitReport& report)
{
    const SkinMap map = {skin_segments(skin.weights), fitted.covered};
    report.segments.clear();
    for (int s = 0; s < num_skin_segments; ++s) report.segments.push_back({segment_name(static_cast<SkinSegment>(s))});
    measure_scan_to_skin(fitted.posed, skin.triangles, map, scan, options.covered, report);
    measure_skin_to_scan(fitted.posed, skin.triangles, map, scan, options.covered, report);
    measure_triangles(fitted.rest, fitted.rest_model, skin.triangles, report);
    measure_heights(fitted.posed, scan, floor, report);
    report.stature = fitted.rest.col(1).maxCoeff() - fitted.rest.col(1).minCoeff();
    report.points = static_cast<std::size_t>(scan.points.rows());
    report.warnings.clear();
    report.defects.clear();
    warn_of_covers(report);
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
    check_segments(options, report);
    check_size(fitted.rest_joints, fitted.rest, skin, options, report);
    if (report.flipped_triangles > options.max_flipped * static_cast<double>(skin.triangles.rows())) {
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
    for (const std::string& note : r.notes) line += "; " + note;
    for (const std::string& warning : r.warnings) line += "; WARNING: " + warning;
    for (const std::string& defect : r.defects) line += "; FAILED: " + defect;
    return line;
}

std::string report_json(const FitReport& r)
{
    nlohmann::json segments = nlohmann::json::object();
    for (const SegmentReport& segment : r.segments) {
        segments[segment.name] = {{"seen", segment.seen},
                                  {"coverage", segment.coverage},
                                  {"mean_m", segment.mean},
                                  {"covered", segment.covered}};
    }
    return nlohmann::json{{"name", r.name},
                          {"segments", segments},
                          {"fit_height_m", r.fit_height},
                          {"scan_height_m", r.scan_height},
                          {"shoulder_breadth_m", r.shoulder_breadth},
                          {"notes", r.notes},
                          {"warnings", r.warnings},
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
