// SPDX-License-Identifier: Apache-2.0
// Data generation: FEM over all pairs of body and pose (NDG 4.1), in shards, resumable.
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/dataset/deformation_file.h"
#include "ndg/dataset/splits.h"
#include "ndg/body/template.h"
#include "ndg/fem/simulator.h"

#include <functional>
#include <string>
#include <vector>

namespace ndg {

/// Every `count`-th pair from `index` on; 0 <= index < count.
struct Shard {
    int index = 0, count = 1;
};
/// "i/n"; throws InputError for anything else.
Shard parse_shard(const std::string& text);

/// A pair with its split and its place in the list of all pairs of all splits.
struct SampleTask {
    int sample_idx = 0;
    SamplePair pair;
    std::string split;
};
/// All pairs in order of splits, of them those of the shard. Throws InputError when none is left.
std::vector<SampleTask> sample_tasks(const Splits& splits, const Shard& shard);

/// SHA-256 over program version, options and input hashes: what a finished sample depends on besides its pair.
std::string simulation_key(const SimulationOptions& options, const Provenance& provenance);
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

/// Figures over all samples, for the tools' reports.
struct SimulationSummary {
    int samples = 0, failed = 0;
    double converged_share = 0;  ///< of all, the failed among them
    double iterations_mean = 0, iterations_median = 0, seconds_mean = 0, inverted_prisms_mean = 0;
    double without_inverted_share = 0;  ///< samples that have no inverted prism
    double residual_relative_max = 0;
    int load_stepped = 0;
};
/// Throws InputError when the set lacks the statistics of simulated samples.
SimulationSummary summarize_simulation(const DeformationSet& set);
/// Two lines for stdout.
std::string simulation_report(const SimulationSummary& summary, const DeformationSet& set);
/// Throws QualityError where a smaller share of the samples converged.
void require_converged(const SimulationSummary& summary, double min_converged);

}  // namespace ndg
