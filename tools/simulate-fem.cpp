// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/interrupt.h"
#include "ndg/core/tool.h"
#include "ndg/dataset/check_dataset.h"
#include "ndg/dataset/sample_inputs.h"
#include "ndg/dataset/shards.h"
#include "ndg/simulation/replay.h"

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool(
        "simulate-fem",
        "Simulates every sample's flesh and skin to static equilibrium: all of --splits, or one body in the poses of "
        "a file; shardable and resumable.",
        "simulate-fem --template template.h5 --bodies bodies.h5 --poses poses.h5 --splits splits.h5 "
        "--output samples.h5");
    SampleInputs inputs;
    std::string output, replay_output, shard_text = "0/1";
    int replay_idx = -1;
    SimulationOptions options;
    double min_converged = 0.99;
    inputs.add_files(tool);
    inputs.add_splits(tool);
    tool.output("output", output, "deformed samples; a shard i of n goes to <output>.shards/<i>-of-<n>.h5", true, true);
    tool.output("replay-output", replay_output, "start and result of --replay, as two samples to look at", false);
    tool.parameter("shard", shard_text, "i/n: only every n-th pair from i on; collect-samples joins the shards");
    tool.parameter("replay", replay_idx, "simulate this sample alone, tell every iteration and keep nothing; -1: none",
                   -1, 1 << 30);
    tool.options(options);
    tool.parameter("min-converged", min_converged, "smallest share of converged samples for exit code 0", 0, 1);
    return tool.run(argc, argv, [&] {
        catch_interrupts();
        inputs.read();
        const Template& body_template = inputs.body_template;
        const BodySet& bodies = inputs.bodies;
        const PoseSet& poses = inputs.poses;
        const Splits& splits = inputs.splits;
        const Shard shard = parse_shard(shard_text);
        require_input(shard.count == 1 || !inputs.by_body(), "--shard {} goes with --splits, not with --body",
                      shard_text);

        if (replay_idx >= 0) {
            const Replay replay = replay_sample(body_template, bodies, poses, splits, replay_idx, options);
            fmt::print("{}", replay_report(replay));
            if (replay.failure.empty()) {
                fmt::print("{}", compare_with_stored(replay.task.key(), replay.result.vertices, output));
            }
            if (!replay_output.empty()) write_replay(replay_output, replay, tool.provenance());
            return;
        }
        const std::string shard_output = shard_path(output, shard);
        const DeformationSet set = simulate_samples(body_template, bodies, poses, sample_tasks(splits, shard), options,
                                                    shard_output, tool.provenance(), interrupt_requested, tool.force());
        const SimulationSummary summary = summarize_simulation(set);
        fmt::print("{}: {}", shard_output, simulation_report(summary, set));
        require_converged(summary, min_converged);
    });
}
