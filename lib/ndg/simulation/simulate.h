// SPDX-License-Identifier: Apache-2.0
// Data generation: FEM over all pairs of body and pose (NDG 4.1), in shards, resumable.
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/body/template.h"
#include "ndg/dataset/deformation_file.h"
#include "ndg/dataset/sample_tasks.h"
#include "ndg/simulation/simulator.h"

#include <functional>
#include <string>
#include <vector>

namespace ndg {

/// When a sample counts as converged, in words.
std::string convergence_text(const SimulationOptions& options);

/// Simulates the tasks on num_threads() threads, one sample a thread, bodies in turn. Each finished sample is committed
/// to <output>.parts at once; valid parts of an earlier run are reused. When all are done they are written to `output`
/// in the order of the tasks, one at a time, and the parts are removed. The samples do not depend on threads, shards or
/// interruptions. Where `output` holds them all already, nothing is done; `force` simulates them again and discards
/// parts of other options. A sample that does not converge is kept with statistic converged = 0; one without result
/// becomes one of the set's failures. Both are reported in the log. The result is open_deformations(output).
/// Throws Interrupted when `stop` returns true (asked before each sample); InputError for indices out of range, when
/// another process is at the same output, or when `output` or its parts stem from other inputs or options.
DeformationSet simulate_samples(const Template& body_template, const BodySet& bodies, const PoseSet& poses,
                                const std::vector<SampleTask>& tasks, const SimulationOptions& options,
                                const std::string& output, const Provenance& provenance,
                                const std::function<bool()>& stop, bool force = false);

/// Of a count: mean over the samples, share of them that have none, largest.
struct CountSummary {
    double mean = 0, without_share = 0, max = 0;
};
/// Of the flesh at one kind of joint, over samples and sides: its volume over that at rest, less one.
struct VolumeChangeSummary {
    std::string joint;
    double mean = 0, min = 0, max = 0;
};

/// Figures over all samples, for the tools' reports.
struct SimulationSummary {
    int samples = 0, failed = 0;
    double converged_share = 0;  ///< of all, the failed among them
    double iterations_mean = 0, iterations_median = 0, seconds_mean = 0;
    CountSummary inverted_prisms, corner_inverted_prisms, intersecting_triangles;
    std::vector<VolumeChangeSummary> volume_changes;
    double residual_relative_max = 0;
    int load_stepped = 0;
};
/// Throws InputError when the set lacks the statistics of simulated samples.
SimulationSummary summarize_simulation(const DeformationSet& set);
/// Lines for stdout.
std::string simulation_report(const SimulationSummary& summary, const DeformationSet& set);
/// Throws QualityError where a smaller share of the samples converged.
void require_converged(const SimulationSummary& summary, double min_converged);

}  // namespace ndg
