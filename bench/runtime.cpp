// SPDX-License-Identifier: Apache-2.0
// Frames of the runtime at the paper's size and at a desk's: milliseconds of every stage beside what reading its bytes
// costs in the same process, memory, and other methods a frame. Without templates: tubes of as many prisms. Without
// models: weights at random, which cost the same.
#include "ndg/runtime/runtime.h"
#include "ndg/body/pose_set.h"
#include "ndg/core/tool.h"
#include "ndg/deform/projective_skinning.h"
#include "ndg/deform/rest_cache.h"
#include "ndg/simulation/corotated_elasticity.h"
#include "ndg/simulation/simulator.h"
#include "report.h"
#include "support/random_network.h"
#include "support/support.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <optional>

using namespace ndg;

namespace {

constexpr double ms = 1000.0;

double seconds_of(const std::function<void()>& work)
{
    const auto begin = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

double peak_memory_gib()
{
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) / (1024.0 * 1024.0);
}

/// The least that a stage can cost: its bytes read by all threads, and nothing done with them.
void read_bytes(const std::byte* begin, std::size_t size)
{
    constexpr std::ptrdiff_t chunk = 1 << 20, ahead = 512, line = 8;  // of words: 64 bytes a line
    const auto* const words = reinterpret_cast<const std::uint64_t*>(begin);
    const auto count = static_cast<std::ptrdiff_t>(size / 64 * 8);
    std::uint64_t all = 0;
#pragma omp parallel for schedule(dynamic, 1) reduction(^ : all)
    for (std::ptrdiff_t first = 0; first < count; first += chunk / 8) {
        std::uint64_t sums[line] = {};
        for (std::ptrdiff_t i = first; i < std::min(count, first + chunk / 8); i += line) {
            __builtin_prefetch(words + i + ahead);
            for (std::ptrdiff_t k = 0; k < line; ++k) sums[k] ^= words[i + k];
        }
        for (const std::uint64_t sum : sums) all ^= sum;
    }
    require(all != 1, "bytes that cannot be");  // so that they are read
}

struct Size {
    std::string name, template_path, model_path;
    int rings = 0;            ///< of the tube that stands for a template
    std::vector<int> widths;  ///< of the network that stands for a model
};

std::vector<Pose> poses_for(const std::string& path, int count)
{
    std::vector<Pose> poses;
    if (!path.empty()) {
        const PoseSet all = read_poses(path);
        for (int i = 0; i < count; ++i) poses.push_back(all.poses[static_cast<std::size_t>(i) * 37 % all.poses.size()]);
        return poses;
    }
    for (int i = 0; i < count; ++i) poses.push_back(test::tube_pose(1.5 * i / count));
    return poses;
}

/// Written by a process of its own, whose memory is not this one's.
void write_in_child(const std::string& path, const Template& body_template, const test::RandomNetwork& network)
{
    const pid_t child = fork();
    require(child >= 0, "no process could be started");
    if (child == 0) {
        int code = 0;
        try {
            test::write_random_network(path, body_template, network);
        } catch (...) {
            code = 1;
        }
        _exit(code);
    }
    int status = 0;
    waitpid(child, &status, 0);
    require(WIFEXITED(status) && WEXITSTATUS(status) == 0, "{}: the model with random weights was not written", path);
}

using Samples = std::map<std::string, std::vector<double>>;

/// Adds medians and 95 % quantiles of milliseconds.
void add_stages(bench::Report& report, const Samples& samples, const std::string& suffix)
{
    for (const auto& [stage, values] : samples) {
        report.add(stage + "_ms_median_" + suffix, ms * bench::quantile(values, 0.5));
        report.add(stage + "_ms_p95_" + suffix, ms * bench::quantile(values, 0.95));
    }
}

/// Frames with one model.
void measure_frames(bench::Report& report, const Template& body_template, const RuntimeModel& model,
                    const std::vector<Pose>& poses, const std::string& suffix)
{
    std::optional<Runtime> made;
    report.add("rig_seconds_" + suffix, seconds_of([&] { made.emplace(body_template, model); }));
    Runtime& runtime = *made;
    report.add("set_body_seconds_" + suffix, seconds_of([&] { runtime.set_body(body_template.rest); }));
    report.add("first_frame_seconds_" + suffix, seconds_of([&] { runtime.set_pose(poses[0]); }));
    for (int i = 0; i < 10; ++i) runtime.set_pose(poses[static_cast<std::size_t>(i) % poses.size()]);
    Samples samples;
    for (const Pose& pose : poses) {
        samples["frame"].push_back(seconds_of([&] { runtime.set_pose(pose); }));
        const FrameSeconds& seconds = runtime.seconds();
        samples["pose"].push_back(seconds.pose);
        samples["network_and_bone_wrap"].push_back(seconds.network);
        samples["bone_wrap"].push_back(seconds.bone_wrap);
        samples["prisms"].push_back(seconds.prisms);
        samples["solve"].push_back(seconds.solve);
        samples["carried"].push_back(seconds.carried);
    }
    report.add("peak_memory_gib_" + suffix, peak_memory_gib());

    // Floors, each beside its stage in turns.
    const InputSpace space(body_template, model.shape_space, model.traits.shape);
    const Eigen::RowVectorXf features = space.features({space.encode(body_template.rest), poses[0]});
    const std::byte* const weights = model.parts.front().layers.front().blocks;
    const std::vector<std::byte> panels(runtime.solver().substitution_bytes());
    const std::vector<std::byte> tables(runtime.forces().table_bytes() +
                                        sizeof(float) * runtime.network().outputs().size());
    const std::vector<std::byte> carried(runtime.carried_anatomy().table_bytes() +
                                         sizeof(float) * static_cast<std::size_t>(runtime.anatomy().size()));
    for (int i = 0; i < 40; ++i) {
        samples["network"].push_back(seconds_of([&] {
#pragma omp parallel
            {
                runtime.network().hidden(features);
                runtime.network().last();
            }
        }));
        samples["network_floor"].push_back(seconds_of([&] { read_bytes(weights, model.weight_bytes()); }));
        // As in a frame: the weights have just gone through the caches.
        const auto floor_of = [&](const std::byte* begin, std::size_t size, int passes) {
            read_bytes(weights, model.weight_bytes());
            return seconds_of([&] {
                for (int pass = 0; pass < passes; ++pass) read_bytes(begin, size);
            });
        };
        samples["solve_floor"].push_back(floor_of(panels.data(), panels.size(), 2));
        samples["prisms_floor"].push_back(floor_of(tables.data(), tables.size(), 1));
        samples["carried_floor"].push_back(floor_of(carried.data(), carried.size(), 1));
    }
    add_stages(report, samples, suffix);
    for (const std::string stage : {"network", "prisms", "solve", "carried"})
        report.add(stage + "_ratio_" + suffix,
                   bench::quantile(samples[stage], 0.5) / bench::quantile(samples[stage + "_floor"], 0.5));
    report.add("weight_megabytes_" + suffix, 1e-6 * static_cast<double>(model.weight_bytes()));
    report.add("fps_median_" + suffix, 1.0 / bench::quantile(samples["frame"], 0.5));
    report.add("fps_p95_" + suffix, 1.0 / bench::quantile(samples["frame"], 0.95));
}

/// What other methods take for a frame of the volume, on all threads where they have work for them.
void measure_others(bench::Report& report, const Template& body_template, const std::vector<Pose>& poses,
                    const PosingOptions& posing, bool with_fem, const std::string& suffix)
{
    const Body& body = body_template.rest;
    const BodyPoser poser(body_template, posing);
    const SkinningWeights weights = body_template.volume_weights();
    RestCache rest(body_template);
    const RestOperators& operators = rest.operators(body);
    const PoissonReconstruction& poisson = rest.poisson(body);
    CorotatedElasticity corotated(body_template);
    std::optional<Simulator> simulator;
    if (with_fem) {
        SimulationOptions options;
        options.posing = posing;
        simulator.emplace(body_template, options);
        simulator->set_body(body);
    }
    Samples samples;
    for (std::size_t i = 0; i < std::min<std::size_t>(poses.size(), 12); ++i) {
        samples["lbs"].push_back(seconds_of([&] {
            const auto motions = forward_kinematics(body_template.skeleton, body.joint_positions, poses[i]);
            linear_blend_skinning(body.volume_vertices, weights, motions);
            linear_blend_skinning(body.skin_vertices, body_template.skin_weights, motions);
        }));
        const PosedBody posed = poser.pose(body, poses[i]);
        posed.bone_wrap();
        ProjectiveOptions none, ten;
        none.iterations = 0;
        ten.iterations = 10;
        const double start = seconds_of([&] { projective_skinning(posed, operators, poisson, none); });
        const double all = seconds_of([&] { projective_skinning(posed, operators, poisson, ten); });
        samples["gradient_skinning"].push_back(start);
        samples["projective_iteration"].push_back((all - start) / ten.iterations);
        samples["corotated"].push_back(seconds_of([&] { corotated.deform(posed); }));
        if (simulator) samples["fem"].push_back(seconds_of([&] { simulator->simulate(poses[i]); }));
    }
    for (const auto& [method, values] : samples)
        report.add(method + "_ms_" + suffix, ms * bench::quantile(values, 0.5));
}

}  // namespace

int main(int argc, char** argv)
{
    Tool tool("bench-runtime", "Times frames of the runtime and their stages.",
              "bench_runtime --paper-template paper.h5 --desk-template template.h5 --poses poses.h5 --output "
              "out/bench/runtime.json");
    Size paper{"paper", "", "", 830, {4096, 4096, 600}}, desk{"desk", "", "", 236, {1024, 1024, 600}};
    std::string poses_path, output;
    int frames = 200;
    bool fem = false;
    tool.input("paper-template", paper.template_path, "template of the paper's size; a tube without it", false);
    tool.input("paper-model", paper.model_path, "runtime model for it; random weights without it", false);
    tool.input("desk-template", desk.template_path, "template of a desk's size; a tube without it", false);
    tool.input("desk-model", desk.model_path, "runtime model for it; random weights without it", false);
    tool.input("poses", poses_path, "poses for the templates, all tried in turn", false);
    tool.parameter("frames", frames, "frames to measure", 1, 100000);
    tool.parameter("fem", fem, "time the simulation too");
    tool.output("output", output, "JSON result", false);
    return tool.run(argc, argv, [&] {
        const test::TemporaryFolder folder;
        bench::Report report("runtime");
        for (const Size& size : {paper, desk}) {
            const bool is_tube = size.template_path.empty();
            Template body_template = is_tube ? test::tube_template(size.rings, 16) : read_template(size.template_path);
            if (is_tube) body_template.file_sha256 = "tube";
            const std::vector<Pose> poses = poses_for(is_tube ? "" : poses_path, frames);
            report.add("prisms_" + size.name, body_template.num_prisms());
            report.add("anatomy_vertices_" + size.name, static_cast<double>(body_template.anatomy_vertices.rows()));
            test::RandomNetwork network;
            network.weights = RuntimeWeights{};
            network.traits.posing = is_tube ? test::bending : PosingOptions{};
            network.widths = size.widths;
            const std::string random_path = folder.file(size.name + ".ndg");
            if (size.model_path.empty()) write_in_child(random_path, body_template, network);
            std::optional<RuntimeModel> model;
            report.add("map_seconds_" + size.name,
                       seconds_of([&] { model.emplace(size.model_path.empty() ? random_path : size.model_path); }));
            measure_frames(report, body_template, *model, poses, size.name);

            // The size of our own best row: networks of regions, each with a fixed basis.
            network.num_parts = 20;
            network.widths = {256, 256};
            network.output_basis = 64;
            write_in_child(folder.file("regional.ndg"), body_template, network);
            measure_frames(report, body_template, RuntimeModel(folder.file("regional.ndg")), poses,
                           size.name + "_regional");
            measure_others(report, body_template, poses, network.traits.posing, fem, size.name);
        }
        report.print();
        if (!output.empty()) report.write(output);
    });
}
