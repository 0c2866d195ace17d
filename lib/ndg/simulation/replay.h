// SPDX-License-Identifier: Apache-2.0
// One sample of a dataset once more, with everything the solver tells.
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/simulation/simulate.h"

#include <string>

namespace ndg {

struct Replay {
    SampleTask task;
    std::string body_name;
    PosingOptions posing;
    Points start;             ///< N_v x 3, gradient skinning, where Newton's method starts; none where that fails too
    SimulationResult result;  ///< no vertices where the sample failed
    std::string failure;      ///< why there is no result; empty: there is one
    double seconds = 0;
};

/// Simulates sample `sample_idx` of all pairs of the splits as simulate_samples does. Throws InputError when there is
/// no such sample.
Replay replay_sample(const Template& body_template, const BodySet& bodies, const PoseSet& poses, const Splits& splits,
                     int sample_idx, const SimulationOptions& options);

/// The table of iterations (of the last solve, where there were load steps) and the figures of the result.
std::string replay_report(const Replay& replay);

/// A deformation file to look at: sample 0 is the start, sample 1 the result (none where the sample failed).
void write_replay(const std::string& path, const Replay& replay, const Provenance& provenance);

}  // namespace ndg
