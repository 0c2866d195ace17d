// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/placement.h"

#include "ndg/core/log.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ndg {
namespace {

constexpr int num_alignments = 4, num_posed = 5, ranking_samples = 300;
constexpr int trial_iterations = 10, trial_samples = 500;
constexpr double trial_reach = 0.02;
/// A placement is kept while its score is below this multiple of the best one's, and this much more, m.
constexpr double kept_ratio = 1.3, kept_margin = 0.001;

struct Trial {
    InitialAlignment alignment;
    Eigen::VectorXd start;
    double distance;  ///< two_way_distance, rigid, m
};

/// Whether two placements put the scan in the same place, arms aside.
bool same_place(const InitialAlignment& a, const InitialAlignment& b)
{
    constexpr double angle = 0.35;
    const Eigen::Matrix3d between = a.template_from_file.linear() * b.template_from_file.linear().transpose();
    return Eigen::AngleAxisd(between).angle() < angle;
}

}  // namespace

ScanTarget make_target(const ScanPoints& scan, const Eigen::Isometry3d& template_from_file)
{
    const Eigen::Matrix3d turn = template_from_file.linear().transpose();
    const Points points = (scan.points * turn).rowwise() + template_from_file.translation().transpose();
    return {points, scan.normals * turn, scan.spacing};
}

std::vector<Placement> find_placements(const std::string& name, const ScanPoints& scan, const ArticulatedModel& model,
                                       const ArticulatedFitOptions& options, int count)
{
    std::vector<Trial> trials;
    // Raised arms make the template higher, the other postures do not.
    const std::vector<std::vector<Eigen::VectorXd>> postures = {
        {Eigen::VectorXd::Zero(model.num_parameters()), model.with_arms({0.15, -1.0, 0.0}),
         model.with_arms({1.0, 0.0, 0.0})},
        {model.with_arms({0.7, 1.0, 0.0})}};
    for (const auto& alike : postures) {
        SkinnedSurface posed = model.skin();
        posed.vertices = model.posed_vertices(alike.front());
        for (const InitialAlignment& alignment : align_initially(scan, posed, num_alignments)) {
            const ScanTarget target = make_target(scan, alignment.template_from_file);
            for (const Eigen::VectorXd& posture : alike) {
                Eigen::VectorXd start = posture;
                start[6] = std::log(alignment.template_scale);
                start.segment<3>(3) =
                    (alignment.template_scale - 1.0) * model.skin().joint_positions.row(0).transpose();
                const double distance =
                    two_way_distance(model.posed_vertices(start), model.skin().triangles, target, ranking_samples);
                trials.push_back({alignment, std::move(start), distance});
            }
        }
    }
    std::stable_sort(trials.begin(), trials.end(),
                     [](const Trial& a, const Trial& b) { return a.distance < b.distance; });
    trials.resize(std::min<std::size_t>(trials.size(), num_posed));

    ArticulatedFitOptions trial_options = options;
    trial_options.iterations = trial_iterations;
    trial_options.samples = trial_samples;
    trial_options.last_reach = trial_reach;
    std::vector<Placement> placements;
    for (const Trial& trial : trials) {
        Placement placement = {trial.alignment, make_target(scan, trial.alignment.template_from_file), {}, 0.0};
        placement.parameters =
            fit_articulated(model, placement.target, trial.start, {}, trial_options, &placement.score);
        log_debug("{}: up {}, distance {:.1f} mm rigid, {:.1f} mm posed", name, to_name(trial.alignment.up),
                  1e3 * trial.distance, 1e3 * placement.score);
        placements.push_back(std::move(placement));
    }
    std::stable_sort(placements.begin(), placements.end(),
                     [](const Placement& a, const Placement& b) { return a.score < b.score; });
    std::vector<Placement> kept;
    for (Placement& placement : placements) {
        if (!kept.empty() && placement.score > kept_ratio * kept.front().score + kept_margin) break;
        const bool known = std::any_of(kept.begin(), kept.end(), [&](const Placement& other) {
            return same_place(placement.alignment, other.alignment);
        });
        if (!known && static_cast<int>(kept.size()) < count) kept.push_back(std::move(placement));
    }
    return kept;
}

}  // namespace ndg
