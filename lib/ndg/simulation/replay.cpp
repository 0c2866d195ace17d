// SPDX-License-Identifier: Apache-2.0
#include "ndg/simulation/replay.h"

#include "ndg/core/error.h"

#include <chrono>

namespace ndg {

Replay replay_sample(const Template& body_template, const BodySet& bodies, const PoseSet& poses, const Splits& splits,
                     int sample_idx, const SimulationOptions& options)
{
    const std::vector<SampleTask> tasks = sample_tasks(splits, Shard{});
    require_input(sample_idx >= 0 && sample_idx < static_cast<int>(tasks.size()),
                  "sample {} lies outside the {} samples of the splits", sample_idx, tasks.size());
    Replay replay;
    replay.task = tasks[sample_idx];
    const SamplePair& pair = replay.task.pair;
    require_pair(pair, bodies.bodies.size(), poses.poses.size());
    const Body& body = bodies.bodies[pair.body_idx];
    const Pose& pose = poses.poses[pair.pose_idx];
    replay.body_name = body.name;
    replay.posing = options.posing;

    const auto start_time = std::chrono::steady_clock::now();
    try {
        Simulator simulator(body_template, options);
        simulator.set_body(body);
        replay.start = simulator.start(pose);
        replay.result = simulator.simulate(pose);
    } catch (const InputError&) {
        throw;
    } catch (const Error& error) {
        replay.failure = error.what();
        replay.result = {};
    }
    replay.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_time).count();
    return replay;
}

std::string replay_report(const Replay& replay)
{
    std::string text =
        fmt::format("sample {}: body {} ({}) in pose {}, split {}\n", replay.task.sample_idx, replay.task.pair.body_idx,
                    replay.body_name, replay.task.pair.pose_idx, replay.task.split);
    if (!replay.failure.empty()) return text + fmt::format("failed: {}\n", replay.failure);
    const NewtonResult& newton = replay.result.newton;
    if (replay.result.load_steps > 0) {
        text += fmt::format("the direct solve failed; {} load steps from rest\n", replay.result.load_steps);
    }
    text += fmt::format("{:>9}  {:>18}  {:>12}  {:>9}  {:>9}  {:>7}  {:>4}\n", "iteration", "energy J", "change J",
                        "residual", "step", "factors", "CG");
    double energy = newton.start_energy_joule;
    text += fmt::format("{:>9}  {:>18.12g}\n", 0, energy);
    for (std::size_t i = 0; i < newton.history.size(); ++i) {
        const NewtonIteration& iteration = newton.history[i];
        text += fmt::format("{:>9}  {:>18.12g}  {:>12.4e}  {:>9.2e}  {:>9.3g}  {:>7}  {:>4}\n", i + 1,
                            iteration.energy_joule, iteration.energy_joule - energy, iteration.residual_relative,
                            iteration.step, iteration.factorizations, iteration.cg_iterations);
        energy = iteration.energy_joule;
    }
    text += fmt::format(
        "Newton's method {}: residual {:.4e} N, relative {:.4e}; {} iterations, {} factorisations, {} inverted prisms, "
        "{} at a "
        "corner, {} intersecting skin triangles, {:.2f} s\n",
        describe(newton.stop), newton.residual_newton, newton.residual_relative, newton.iterations,
        newton.factorizations, replay.result.inverted_prisms.by_volume, replay.result.inverted_prisms.at_corners,
        replay.result.intersecting_triangles, replay.seconds);
    return text;
}

void write_replay(const std::string& path, const Replay& replay, const Provenance& provenance)
{
    require(replay.start.rows() > 0, "{}: is not written, for sample {} has not even a start", path,
            replay.task.sample_idx);
    DeformationSet set;
    set.method = "FEM replay";
    set.posing = replay.posing;
    set.add(replay.task.pair, replay.task.split, replay.start);
    if (replay.failure.empty()) set.add(replay.task.pair, replay.task.split, replay.result.vertices);
    write_deformations(path, set, provenance);
}

}  // namespace ndg
