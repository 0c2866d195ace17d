// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/interrupt.h"
#include "ndg/core/tool.h"
#include "ndg/fem/simulate.h"

#include <optional>

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool("simulate-fem", "Simulates every sample's flesh and skin to static equilibrium; shardable and resumable.",
              "simulate-fem --template template.h5 --bodies bodies.h5 --poses poses.h5 --splits splits.h5 "
              "--output samples.h5");
    std::string template_path, bodies_path, poses_path, splits_path, output, shard = "0/1";
    std::vector<std::string> merge;
    SimulationOptions options;
    double min_converged = 0.99;
    tool.input("template", template_path, "template");
    tool.input("bodies", bodies_path, "bodies");
    tool.input("poses", poses_path, "poses");
    tool.input("splits", splits_path, "splits and pairs");
    tool.input("merge", merge, "outputs of all shards: joins them instead of simulating", false);
    tool.output("output", output, "deformed samples", true, true);
    tool.parameter("shard", shard, "i/n: only every n-th pair from i on, into an output of its own");
    tool.parameter("young-muscle", options.material.young_muscle_pascal, "Young's modulus of the muscle layer, Pa", 1,
                   1e9);
    tool.parameter("young-fat", options.material.young_fat_pascal, "Young's modulus of the fat layer, Pa", 1, 1e9);
    tool.parameter("poisson-ratio", options.material.poisson_ratio, "Poisson's ratio of both layers", 0.13, 0.4999);
    tool.parameter("flesh-stiffness", options.material.flesh_stiffness, "factor k_f of the flesh energy", 1e-6, 1e6);
    tool.parameter("stretch-stiffness", options.material.stretch_stiffness, "factor k_s of skin stretching, J", 0, 1e6);
    tool.parameter("bend-stiffness", options.material.bend_stiffness, "factor k_b of skin bending, J", 0, 1e6);
    tool.parameter("relative-tolerance", options.newton.relative_tolerance,
                   "converged at this share of forces out of balance", 1e-14, 0.1);
    tool.parameter("absolute-tolerance", options.newton.absolute_tolerance_newton,
                   "or at this norm of the forces out of balance, N", 0, 1);
    tool.parameter("max-iterations", options.newton.max_iterations, "limit of Newton iterations a solve", 1, 10000);
    tool.parameter("load-steps", options.load_steps, "steps from rest where the direct solve fails; 0: none", 0, 1000);
    tool.parameter("min-converged", min_converged, "smallest share of converged samples for exit code 0", 0, 1);
    return tool.run(argc, argv, [&] {
        catch_interrupts();
        const Template body_template = read_template(template_path);
        const BodySet bodies = read_bodies(bodies_path, body_template);
        const PoseSet poses = read_poses(poses_path);
        const Splits splits = read_splits(splits_path, static_cast<int>(bodies.bodies.size()), poses.size());

        DeformationSet set;
        if (merge.empty()) {
            set = simulate_samples(body_template, bodies, poses, sample_tasks(splits, parse_shard(shard)), options,
                                   output, tool.provenance(), interrupt_requested);
        } else {
            set = merge_shards(merge, splits);
            require_input(set.num_volume_vertices == body_template.num_volume_vertices(),
                          "{}: samples have {} vertices, the template {}", merge.front(), set.num_volume_vertices,
                          body_template.num_volume_vertices());
            write_deformations(output, set, tool.provenance());
        }
        const SimulationSummary summary = summarize_simulation(set);
        fmt::print(
            "{} samples, {:.2f} % converged (out-of-balance force <= {:g} of all element forces, or <= {:g} N)\n",
            summary.samples, 100 * summary.converged_share, options.newton.relative_tolerance,
            options.newton.absolute_tolerance_newton);
        fmt::print(
            "iterations: mean {:.1f}, median {:.0f}; {} in load steps; {:.2f} core-seconds a sample; "
            "{:.2f} inverted prisms a sample\n",
            summary.iterations_mean, summary.iterations_median, summary.load_stepped, summary.seconds_mean,
            summary.inverted_prisms_mean);
        if (summary.converged_share < min_converged) {
            throw QualityError(
                fmt::format("{:.2f} % of the samples converged, fewer than {:.2f} %; largest relative "
                            "residual {:.1e}",
                            100 * summary.converged_share, 100 * min_converged, summary.residual_relative_max));
        }
    });
}
