// SPDX-License-Identifier: Apache-2.0
#include "ndg/capture/measure_motion.h"

#include "ndg/core/error.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

constexpr double millimetre = 1e-3;

double rms_mm(const Eigen::VectorXd& variances)
{
    return std::sqrt(variances.mean()) / millimetre;
}

/// Normal and two directions across it, as columns.
Eigen::Matrix3d frame_about(const Eigen::Vector3d& normal)
{
    Eigen::Matrix3d frame;
    frame.col(0) = normal.normalized();
    Eigen::Index least = 0;
    normal.cwiseAbs().minCoeff(&least);
    frame.col(1) = frame.col(0).cross(Eigen::Vector3d::Unit(least)).normalized();
    frame.col(2) = frame.col(0).cross(frame.col(1));
    return frame;
}

/// First frame of the simulation of a sequence. Throws InputError where it does not fit.
int simulated_begin(const Avatar& avatar, const CaptureSequence& sequence, const DynamicsReader& simulation)
{
    const DynamicsSet& set = simulation.set();
    require_input(set.num_vertices() == avatar.num_vertices() && (set.rest - avatar.rest).cwiseAbs().maxCoeff() < 1e-6,
                  "the simulation is of another body than avatar {}", avatar.name);
    require_input(std::abs(set.frame_rate_hertz - sequence.frame_rate_hertz) < 1e-9 * sequence.frame_rate_hertz,
                  "the simulation has {} frames a second, sequence \"{}\" of the capture {}", set.frame_rate_hertz,
                  sequence.name, sequence.frame_rate_hertz);
    const auto found = std::find(set.sequence_names.begin(), set.sequence_names.end(), sequence.name);
    require_input(found != set.sequence_names.end(), "the simulation has no motion \"{}\"", sequence.name);
    const auto [begin, end] = set.frames_of(static_cast<int>(found - set.sequence_names.begin()));
    require_input(end - begin >= sequence.num_recorded(), "the simulation of \"{}\" has {} frames, the capture {}",
                  sequence.name, end - begin, sequence.num_recorded());
    return begin;
}

MotionMeasure measure(const Avatar& avatar, const MeasuredSkin& skin, const CaptureSequence& sequence,
                      const DynamicsReader* simulation)
{
    MotionMeasure result;
    result.sequence = sequence.name;
    result.num_frames = sequence.num_frames();
    result.num_missing = sequence.num_recorded() - sequence.num_frames();
    result.captured = motion_variance(avatar, skin, sequence);
    Eigen::Index liveliest = 0;
    result.captured.total().maxCoeff(&liveliest);
    result.liveliest.skin_vertex = skin.skin_vertices[static_cast<std::size_t>(liveliest)];
    result.liveliest.captured.resize(sequence.num_frames(), 3);
    const int begin = simulation == nullptr ? 0 : simulated_begin(avatar, sequence, *simulation);
    if (simulation != nullptr) result.liveliest.simulated.resize(sequence.num_frames(), 3);

    const AvatarPoser poser(avatar);
    const Eigen::Matrix3d axes = frame_about(skin.normals.row(liveliest).transpose());
    const auto offset = [&](const Points& unposed) {
        return Eigen::RowVector3d((unposed.row(liveliest) - skin.rest.row(liveliest)) * axes);
    };
    MotionVarianceSum sum(skin.rest, skin.normals);
    for (int f = 0; f < sequence.num_frames(); ++f) {
        const auto k = static_cast<std::size_t>(f);
        const std::vector<AffineMap> maps = poser.world_from_unposed(sequence.poses[k]);
        result.liveliest.captured.row(f) = offset(skin.unposed_skin(sequence.vertices[k], maps));
        if (simulation == nullptr) continue;
        const int frame = begin + sequence.frame_numbers[k] - sequence.frame_numbers[0];
        const Points unposed = skin.unposed_volume(simulation->frame(frame), maps);
        result.liveliest.simulated.row(f) = offset(unposed);
        sum.add(unposed);
    }
    if (simulation != nullptr) result.simulated = sum.variance();
    return result;
}

nlohmann::json rows_mm(const Points& points)
{
    nlohmann::json rows = nlohmann::json::array();
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        rows.push_back({points(i, 0) / millimetre, points(i, 1) / millimetre, points(i, 2) / millimetre});
    }
    return rows;
}

}  // namespace

double MotionMeasure::skinned_error(VarianceMetric metric) const
{
    return metric == VarianceMetric::isotropic ? captured.total().squaredNorm() : captured.stacked().squaredNorm();
}

double MotionMeasure::simulated_error(VarianceMetric metric) const
{
    require(simulated.has_value(), "sequence \"{}\" was not simulated", sequence);
    return variance_error(*simulated, captured, metric);
}

double MotionMeasure::reduction(VarianceMetric metric) const
{
    return 1 - simulated_error(metric) / skinned_error(metric);
}

std::vector<MotionMeasure> measure_motion(const Avatar& avatar, const MeasuredSkin& skin, const Capture& capture,
                                          const DynamicsReader* simulation)
{
    require_input(capture.has_poses(), "the capture of {} has no poses, by which its skin could be unposed",
                  capture.subject);
    std::vector<MotionMeasure> measures;
    for (const CaptureSequence& sequence : capture.sequences) {
        measures.push_back(measure(avatar, skin, sequence, simulation));
    }
    return measures;
}

std::string motion_measures_json(const std::string& subject, const std::vector<MotionMeasure>& measures)
{
    nlohmann::json rows = nlohmann::json::array();
    for (const MotionMeasure& m : measures) {
        nlohmann::json row = {
            {"sequence", m.sequence},
            {"frames", m.num_frames},
            {"missing", m.num_missing},
            {"captured_normal_rms_mm", rms_mm(m.captured.normal)},
            {"captured_tangent_rms_mm", rms_mm(m.captured.tangent)},
            {"skinned_error_m4", m.skinned_error(VarianceMetric::anisotropic)},
            {"liveliest", {{"skin_vertex", m.liveliest.skin_vertex}, {"captured_mm", rows_mm(m.liveliest.captured)}}}};
        if (m.simulated) {
            row["simulated_normal_rms_mm"] = rms_mm(m.simulated->normal);
            row["simulated_tangent_rms_mm"] = rms_mm(m.simulated->tangent);
            row["simulated_error_m4"] = m.simulated_error(VarianceMetric::anisotropic);
            row["variance_reduction"] = m.reduction(VarianceMetric::anisotropic);
            row["variance_reduction_isotropic"] = m.reduction(VarianceMetric::isotropic);
            row["liveliest"]["simulated_mm"] = rows_mm(m.liveliest.simulated);
        }
        rows.push_back(row);
    }
    return nlohmann::json{{"subject", subject}, {"sequences", rows}}.dump(1) + "\n";
}

std::string motion_measures_table(const std::vector<MotionMeasure>& measures)
{
    std::string text = fmt::format("{:<24} {:>7} {:>10} {:>11}{}\n", "sequence", "frames", "normal mm", "tangent mm",
                                   measures.empty() || !measures[0].simulated
                                       ? ""
                                       : fmt::format(" {:>12} {:>13} {:>10}", "simulated: n", "t", "reduction"));
    for (const MotionMeasure& m : measures) {
        text += fmt::format("{:<24} {:>7} {:>10.2f} {:>11.2f}", m.sequence, m.num_frames, rms_mm(m.captured.normal),
                            rms_mm(m.captured.tangent));
        if (m.simulated) {
            text += fmt::format(" {:>12.2f} {:>13.2f} {:>9.1f}%", rms_mm(m.simulated->normal),
                                rms_mm(m.simulated->tangent), 100 * m.reduction(VarianceMetric::anisotropic));
        }
        text += "\n";
    }
    return text;
}

}  // namespace ndg
