// SPDX-License-Identifier: Apache-2.0
// Motions of one body through time as a batch: resumable within a motion, one motion a thread.
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/dataset/sample_tasks.h"
#include "ndg/dynamics/dynamics_file.h"
#include "ndg/dynamics/motion_simulation.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace ndg {

/// To be raised whenever motions of the same inputs and options come out otherwise.
inline constexpr int dynamics_method_version = 1;

/// A motion at the step rate.
struct DynamicSequence {
    int index = 0;  ///< among all that are asked for
    std::string name;
    std::vector<Pose> poses;
};
/// The clips of the given names, or all, each at `rate` Hz (resample_poses). Throws InputError for a name that is not
/// there and for a set without clips.
std::vector<DynamicSequence> sequences_of(const PoseSet& poses, const std::vector<std::string>& names, double rate);
/// Those that a shard has. Throws InputError where there are none.
std::vector<DynamicSequence> shard_of(const std::vector<DynamicSequence>& sequences, const Shard& shard);

/// A body for one thread, with what it meets.
struct DynamicActor {
    std::unique_ptr<DrivenBody> body;
    std::unique_ptr<StepHook> hook;  ///< may be none
};

struct DynamicsRun {
    std::string model;                         ///< name in the file
    std::function<DynamicActor()> make_actor;  ///< for each sequence; called by several threads
    SceneLoads loads;
    DynamicsOptions options;
    std::string options_key;  ///< of all that affects the result
};

/// Simulates the sequences on num_threads() threads. Every block of frames is committed to <output>.parts at once; a
/// run that was killed goes on from the last one, with the same result bit for bit. When all are done they are written
/// to `output` and the parts removed. Where `output` holds the same already, nothing is done; `force` discards it and
/// parts of other options. A sequence that cannot go on becomes one of the set's failures. Returns the set. Throws
/// Interrupted when `stop` returns true (asked before each block); InputError where `output` or its parts stem from
/// other inputs or options.
DynamicsSet simulate_dynamics(const DynamicsRun& run, const std::vector<DynamicSequence>& sequences,
                              const std::string& output, const Provenance& provenance,
                              const std::function<bool()>& stop, bool force = false);

/// Lines for stdout.
std::string dynamics_report(const DynamicsSet& set);
/// Throws QualityError where a smaller share of the frames converged, or a sequence failed.
void require_converged(const DynamicsSet& set, double min_converged);

}  // namespace ndg
