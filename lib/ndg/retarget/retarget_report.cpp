// SPDX-License-Identifier: Apache-2.0
#include "ndg/retarget/retarget_report.h"

#include "ndg/core/error.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

using json = nlohmann::ordered_json;

constexpr double millimetres = 1000.0;
constexpr double degrees = 180.0 / M_PI;

/// Rounded to what is meaningful, so that reports of equal runs are equal and short.
double rounded(double value, double step)
{
    return std::round(value / step) * step;
}

json to_json(const RetargetReport& report)
{
    json out;
    out["clip"] = report.clip_name;
    out["file"] = report.path;
    out["joint_map"] = report.joint_map;
    out["frames"] = report.num_frames;
    out["frame_rate"] = report.frame_rate;
    out["frame_rate_assumed"] = report.frame_rate_assumed;
    out["scale_metres_per_unit"] = report.scale;
    out["metres_per_unit"] = report.metres_per_unit;
    out["unit_from"] = report.unit_from;
    out["performer_stature_metres"] = rounded(report.performer_stature, 1e-3);
    out["up_axis"] = report.up_axis;
    out["front_axis"] = report.front_axis;
    out["axes_from"] = report.axes_from;
    out["skipped_frames"] = report.num_skipped;
    out["glitch_frames"] = report.num_glitch_frames;
    out["poses"] = report.num_poses;
    out["dropped_as_glitches"] = report.num_dropped_glitches;
    out["dropped_beyond_limit"] = report.num_dropped_angles;
    out["fastest_joint_degrees_per_second"] = rounded(report.max_joint_speed * degrees, 0.1);
    out["mean_error_mm"] = rounded(report.mean_error * millimetres, 1e-3);
    out["max_error_mm"] = rounded(report.max_error * millimetres, 1e-3);
    out["mean_error_before_mm"] = rounded(report.mean_error_before * millimetres, 1e-3);
    out["mean_error_uniform_mm"] = rounded(report.mean_error_uniform * millimetres, 1e-3);
    out["mean_direction_error_degrees"] = rounded(report.mean_direction_error * degrees, 1e-4);
    out["reference"] = report.reference;
    out["segments"] = json::array();
    for (const SegmentError& error : report.segment_errors) {
        out["segments"].push_back({{"segment", error.segment},
                                   {"mean_degrees", rounded(error.mean * degrees, 1e-2)},
                                   {"max_degrees", rounded(error.max * degrees, 1e-2)}});
    }
    out["dropped_joints"] = json::array();
    for (const DroppedJoint& dropped : report.dropped_joints) {
        out["dropped_joints"].push_back({{"joint", dropped.joint},
                                         {"poses", dropped.num_poses},
                                         {"largest_angle_degrees", rounded(dropped.max_angle * degrees, 0.1)},
                                         {"limit_degrees", rounded(dropped.limit * degrees, 0.1)}});
    }
    out["mean_iterations"] = rounded(report.mean_iterations, 1e-2);
    out["largest_jump_degrees"] = rounded(report.max_jump * degrees, 0.1);
    out["largest_source_jump_degrees"] = rounded(report.max_source_jump * degrees, 0.1);
    out["jumps"] = report.num_jumps;
    out["new_jumps"] = report.num_new_jumps;
    out["joints"] = json::array();
    for (const JointError& error : report.joint_errors) {
        out["joints"].push_back({{"joint", error.joint},
                                 {"mean_mm", rounded(error.mean * millimetres, 1e-3)},
                                 {"max_mm", rounded(error.max * millimetres, 1e-3)},
                                 {"mean_before_mm", rounded(error.mean_before * millimetres, 1e-3)},
                                 {"mean_uniform_mm", rounded(error.mean_uniform * millimetres, 1e-3)}});
    }
    if (!report.limits_checked) return out;
    out["limits_clamped"] = report.limits_clamped;
    out["violating_frames"] = report.num_violating_frames;
    out["far_frames"] = report.num_far_frames;
    out["limit_hits"] = json::array();
    for (const LimitHits& hits : report.limit_hits) {
        out["limit_hits"].push_back({{"joint", hits.joint},
                                     {"frames", hits.num_frames},
                                     {"far_frames", hits.num_far_frames},
                                     {"largest_excess_degrees", rounded(hits.max_excess * degrees, 0.1)}});
    }
    return out;
}

/// Characters of UTF-8 text, for columns.
std::size_t width(const std::string& text)
{
    return static_cast<std::size_t>(
        std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

/// Which joints leave their published ranges by more than 10 degrees, and in what share of the frames.
std::string limits_line(const RetargetSummary& summary)
{
    constexpr std::size_t most_named = 6;
    const double percent = 100.0 / summary.num_checked_frames;
    std::string text = fmt::format(
        "{:.1f} % of the frames have a joint outside its published range, {:.1f} % one more than {:.0f} degrees",
        percent * summary.num_violating_frames, percent * summary.num_far_frames, far_violation_angle * degrees);
    for (std::size_t k = 0; k < summary.limit_hits.size() && k < most_named; ++k) {
        const LimitHits& hits = summary.limit_hits[k];
        if (hits.num_far_frames == 0) break;
        text += fmt::format("{} {} {:.1f} %", k == 0 ? ":" : ",", hits.joint, percent * hits.num_far_frames);
    }
    return text + "\n";
}

}  // namespace

const SegmentError* RetargetReport::worst_segment() const
{
    const auto worst = std::max_element(segment_errors.begin(), segment_errors.end(),
                                        [](const SegmentError& a, const SegmentError& b) { return a.mean < b.mean; });
    return worst == segment_errors.end() ? nullptr : &*worst;
}

RetargetSummary summarise(const std::vector<RetargetReport>& reports)
{
    RetargetSummary summary;
    std::vector<double> errors;
    for (const RetargetReport& report : reports) {
        errors.push_back(report.mean_error);
        if (summary.worst_clip.empty() || report.mean_error > summary.worst_error) {
            summary.worst_error = report.mean_error;
            summary.worst_clip = report.clip_name;
        }
        summary.num_new_jumps += report.num_new_jumps;
        summary.num_frames += report.num_frames;
        summary.num_violating_frames += report.num_violating_frames;
        summary.num_far_frames += report.num_far_frames;
        if (report.limits_checked) summary.num_checked_frames += report.num_frames - report.num_skipped;
        for (const LimitHits& hits : report.limit_hits) {
            auto sum = std::find_if(summary.limit_hits.begin(), summary.limit_hits.end(),
                                    [&](const LimitHits& h) { return h.joint == hits.joint; });
            if (sum == summary.limit_hits.end()) sum = summary.limit_hits.insert(sum, {hits.joint, 0, 0.0, 0});
            sum->num_frames += hits.num_frames;
            sum->num_far_frames += hits.num_far_frames;
            sum->max_excess = std::max(sum->max_excess, hits.max_excess);
        }
        const SegmentError* worst = report.worst_segment();
        if (worst != nullptr && worst->mean > summary.worst_segment.mean) {
            summary.worst_segment = *worst;
            summary.worst_segment_clip = report.clip_name;
        }
    }
    std::stable_sort(summary.limit_hits.begin(), summary.limit_hits.end(),
                     [](const LimitHits& a, const LimitHits& b) { return a.num_far_frames > b.num_far_frames; });
    if (errors.empty()) return summary;
    std::sort(errors.begin(), errors.end());
    const std::size_t half = errors.size() / 2;
    summary.median_error = errors.size() % 2 == 1 ? errors[half] : 0.5 * (errors[half - 1] + errors[half]);
    return summary;
}

std::string report_table(const std::vector<RetargetReport>& reports)
{
    std::size_t longest = 4;
    for (const RetargetReport& report : reports) longest = std::max(longest, width(report.clip_name));
    const auto padded = [&](const std::string& name) { return name + std::string(longest - width(name), ' '); };
    std::string table = fmt::format(
        "{}  frames    Hz  poses  drop  error mm (max)  before  uniform  segment deg  jump deg (source)  new  beyond "
        "10 deg\n",
        padded("clip"));
    for (const RetargetReport& r : reports) {
        table += fmt::format(
            "{} {:7d} {:4.0f}{} {:6d} {:5d} {:8.2f} {:7.1f} {:7.2f} {:8.1f} {:12.1f} {:10.1f} {:8.1f} {:4d}  {}\n",
            padded(r.clip_name), r.num_frames, r.frame_rate, r.frame_rate_assumed ? '?' : ' ', r.num_poses,
            r.num_dropped_glitches + r.num_dropped_angles, r.mean_error * millimetres, r.max_error * millimetres,
            r.mean_error_before * millimetres, r.mean_error_uniform * millimetres,
            r.worst_segment() != nullptr ? r.worst_segment()->mean * degrees : 0.0, r.max_jump * degrees,
            r.max_source_jump * degrees, r.num_new_jumps,
            r.limits_checked
                ? fmt::format("{:8.1f}%", 100.0 * r.num_far_frames / std::max(1, r.num_frames - r.num_skipped))
                : std::string("       -"));
    }
    const RetargetSummary summary = summarise(reports);
    if (!summary.worst_segment_clip.empty())
        table += fmt::format("segments point as the source's to {:.1f} degrees in the mean at worst ({} of {})\n",
                             summary.worst_segment.mean * degrees, summary.worst_segment.segment,
                             summary.worst_segment_clip);
    if (summary.num_checked_frames > 0) table += limits_line(summary);
    table += fmt::format(
        "{} clips, {} frames: mean joint position error {:.2f} mm (median of the clips), worst {:.2f} mm ({}); {} "
        "jumps "
        "above {:.0f} degrees that the source does not have\n",
        reports.size(), summary.num_frames, summary.median_error * millimetres, summary.worst_error * millimetres,
        summary.worst_clip, summary.num_new_jumps, jump_angle * degrees);
    return table;
}

std::string report_json(const std::vector<RetargetReport>& reports)
{
    const RetargetSummary summary = summarise(reports);
    json out;
    out["format"] = "ndg-motion-report";
    out["clips"] = reports.size();
    out["frames"] = summary.num_frames;
    out["median_error_mm"] = rounded(summary.median_error * millimetres, 1e-3);
    out["worst_error_mm"] = rounded(summary.worst_error * millimetres, 1e-3);
    out["worst_clip"] = summary.worst_clip;
    out["new_jumps"] = summary.num_new_jumps;
    out["violating_frames"] = summary.num_violating_frames;
    out["far_frames"] = summary.num_far_frames;
    out["far_degrees"] = far_violation_angle * degrees;
    out["jump_degrees"] = jump_angle * degrees;
    out["violation_degrees"] = violation_angle * degrees;
    out["reports"] = json::array();
    for (const RetargetReport& report : reports) out["reports"].push_back(to_json(report));
    // Names of files need not be valid UTF-8; what is not becomes a question mark.
    return out.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace ndg
