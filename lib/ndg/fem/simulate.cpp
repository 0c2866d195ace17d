// SPDX-License-Identifier: Apache-2.0
#include "ndg/fem/simulate.h"

#include "ndg/core/error.h"
#include "ndg/core/hash.h"
#include "ndg/core/log.h"
#include "ndg/core/progress.h"
#include "ndg/core/threads.h"
#include "ndg/deform/rest_cache.h"
#include "ndg/fem/sample_parts.h"

#include <omp.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <ctime>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <numeric>
#include <tuple>

namespace ndg {

namespace {

/// CHOLMOD opens parallel sections of four threads of its own; within samples that run side by side they would only
/// wait for each other. Lets `levels` nested sections run in parallel until the end of the scope.
class ParallelLevels {
public:
    explicit ParallelLevels(int levels) : previous_(omp_get_max_active_levels()) { omp_set_max_active_levels(levels); }
    ~ParallelLevels() { omp_set_max_active_levels(previous_); }
    ParallelLevels(const ParallelLevels&) = delete;
    ParallelLevels& operator=(const ParallelLevels&) = delete;

private:
    int previous_;
};

/// Processor time of this thread, so that a busy machine does not show in the statistics.
double thread_seconds()
{
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

SamplePart make_part(const SamplePair& pair, const SimulationResult& result, double seconds)
{
    SamplePart part;
    part.pair = pair;
    part.vertices.resize(static_cast<std::size_t>(result.vertices.size()));
    Eigen::Map<Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>>(part.vertices.data(), result.vertices.rows(),
                                                                         3) = result.vertices.cast<float>();
    part.statistics = {{"energy_joule", result.newton.energy_joule},
                       {"residual_newton", result.newton.residual_newton},
                       {"residual_relative", result.newton.residual_relative},
                       {"iterations", result.newton.iterations},
                       {"converged", result.newton.converged()},
                       {"load_steps", result.load_steps},
                       {"inverted_prisms", result.inverted_prisms},
                       {"seconds", seconds}};
    return part;
}

/// Tasks without a valid part, bodies together.
std::vector<SampleTask> open_tasks(const std::vector<SampleTask>& tasks, const PartFolder& parts)
{
    std::vector<SampleTask> open;
    for (const SampleTask& task : tasks) {
        if (!parts.read(task.sample_idx, task.pair)) open.push_back(task);
    }
    std::stable_sort(open.begin(), open.end(),
                     [](const SampleTask& a, const SampleTask& b) { return a.pair.body_idx < b.pair.body_idx; });
    return open;
}

DeformationSet collect(const std::vector<SampleTask>& tasks, const PartFolder& parts, int num_volume_vertices)
{
    DeformationSet set;
    set.method = "FEM";
    set.num_volume_vertices = num_volume_vertices;
    for (const SampleTask& task : tasks) {
        std::optional<SamplePart> part = parts.read(task.sample_idx, task.pair);
        require(part.has_value(), "{}: the part of sample {} cannot be read back", parts.path(), task.sample_idx);
        set.pairs.push_back(task.pair);
        set.pair_splits.push_back(task.split);
        set.vertices.push_back(std::move(part->vertices));
        for (const auto& [name, value] : part->statistics) set.statistics[name].push_back(value);
    }
    return set;
}

double mean(const std::vector<double>& values)
{
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace

Shard parse_shard(const std::string& text)
{
    Shard shard;
    char rest = 0;
    require_input(std::sscanf(text.c_str(), "%d/%d%c", &shard.index, &shard.count, &rest) == 2 && shard.count > 0 &&
                      shard.index >= 0 && shard.index < shard.count,
                  "shard is \"{}\", expected i/n with 0 <= i < n", text);
    return shard;
}

std::vector<SampleTask> sample_tasks(const Splits& splits, const Shard& shard)
{
    std::vector<SampleTask> tasks;
    int sample_idx = 0;
    for (const std::string& split : split_names) {
        const auto found = splits.pairs.find(split);
        if (found == splits.pairs.end()) continue;
        for (const SamplePair& pair : found->second) {
            if (sample_idx % shard.count == shard.index) tasks.push_back({sample_idx, pair, split});
            ++sample_idx;
        }
    }
    require_input(!tasks.empty(), "shard {}/{} of {} samples has none", shard.index, shard.count, sample_idx);
    return tasks;
}

std::string simulation_key(const SimulationOptions& options, const Provenance& provenance)
{
    const MaterialOptions& material = options.material;
    const NewtonOptions& newton = options.newton;
    std::string text = fmt::format("{} {}\n{} {} {} {} {} {}\n{} {} {} {}\n", project_version(), project_commit(),
                                   material.young_muscle_pascal, material.young_fat_pascal, material.poisson_ratio,
                                   material.flesh_stiffness, material.stretch_stiffness, material.bend_stiffness,
                                   newton.relative_tolerance, newton.absolute_tolerance_newton, newton.max_iterations,
                                   options.load_steps);
    for (const Provenance::Input& input : provenance.inputs) text += input.sha256 + "\n";
    return sha256(text);
}

DeformationSet simulate_samples(const Template& body_template, const BodySet& bodies, const PoseSet& poses,
                                const std::vector<SampleTask>& tasks, const SimulationOptions& options,
                                const std::string& output, const Provenance& provenance,
                                const std::function<bool()>& stop)
{
    options.check();
    for (const SampleTask& task : tasks) require_pair(task.pair, bodies.bodies.size(), poses.poses.size());
    const PartFolder parts(output, simulation_key(options, provenance), body_template.num_volume_vertices());
    const std::vector<SampleTask> open = open_tasks(tasks, parts);
    if (open.size() < tasks.size()) {
        log_info("{} of {} samples stand already in {}", tasks.size() - open.size(), tasks.size(), parts.path());
    }

    Progress progress("simulating", open.size());
    std::atomic<std::size_t> next{0};
    std::atomic<bool> stopped{false};
    std::mutex mutex;  // HDF5 is not thread-safe
    std::exception_ptr failure;
    const int threads = std::max(1, std::min<int>(num_threads(), static_cast<int>(open.size())));
    const ParallelLevels levels(threads > 1 ? 1 : 0);
#pragma omp parallel num_threads(threads)
    try {
        std::unique_ptr<Simulator> simulator;
        int body_idx = -1;
        while (!stopped) {
            if (next >= open.size()) break;
            if (stop()) stopped = true;
            const std::size_t place = stopped ? open.size() : next++;
            if (place >= open.size()) break;
            const SampleTask& task = open[place];
            const double start = thread_seconds();
            if (!simulator) simulator = std::make_unique<Simulator>(body_template, options);
            if (task.pair.body_idx != body_idx) {
                body_idx = task.pair.body_idx;
                simulator->set_body(bodies.bodies[static_cast<std::size_t>(body_idx)]);
            }
            const SimulationResult result =
                simulator->simulate(poses.poses[static_cast<std::size_t>(task.pair.pose_idx)]);
            const SamplePart part = make_part(task.pair, result, thread_seconds() - start);
            if (!result.newton.converged()) {
                log_warning(
                    "sample {} (body {}, pose {}) did not converge: Newton's method {} at a relative residual "
                    "of {:.1e} after {} iterations",
                    task.sample_idx, task.pair.body_idx, task.pair.pose_idx, describe(result.newton.stop),
                    result.newton.residual_relative, result.newton.iterations);
            }
            const std::lock_guard<std::mutex> lock(mutex);
            parts.write(task.sample_idx, part, provenance);
            progress.advance();
        }
    } catch (...) {
        const std::lock_guard<std::mutex> lock(mutex);
        if (!failure) failure = std::current_exception();
        stopped = true;
    }
    if (failure) std::rethrow_exception(failure);
    if (stopped) {
        throw Interrupted(fmt::format(
            "interrupted; finished samples are kept in {}, the same command goes on from there", parts.path()));
    }
    DeformationSet set = collect(tasks, parts, body_template.num_volume_vertices());
    write_deformations(output, set, provenance);
    parts.remove();
    return set;
}

DeformationSet merge_shards(const std::vector<std::string>& shard_paths, const Splits& splits)
{
    using PairKey = std::tuple<std::string, int, int>;
    std::vector<DeformationSet> shards;
    std::map<PairKey, std::pair<std::size_t, std::size_t>> places;
    for (const std::string& path : shard_paths) {
        DeformationSet shard = read_deformations(path);
        require_input(shards.empty() || shard.num_volume_vertices == shards.front().num_volume_vertices,
                      "{}: samples have {} vertices, those of {} have {}", path, shard.num_volume_vertices,
                      shard_paths.front(), shards.empty() ? 0 : shards.front().num_volume_vertices);
        for (std::size_t i = 0; i < shard.pairs.size(); ++i) {
            const SamplePair& pair = shard.pairs[i];
            const bool is_new =
                places.emplace(PairKey{shard.pair_splits[i], pair.body_idx, pair.pose_idx}, std::pair{shards.size(), i})
                    .second;
            require_input(is_new, "{}: body {} in pose {} of split {} stands in another shard already", path,
                          pair.body_idx, pair.pose_idx, shard.pair_splits[i]);
        }
        shards.push_back(std::move(shard));
    }
    require_input(!shards.empty(), "no shards are given to merge");

    DeformationSet merged;
    merged.method = shards.front().method;
    merged.num_volume_vertices = shards.front().num_volume_vertices;
    const std::vector<SampleTask> tasks = sample_tasks(splits, Shard{});
    for (const SampleTask& task : tasks) {
        const auto found = places.find(PairKey{task.split, task.pair.body_idx, task.pair.pose_idx});
        require_input(found != places.end(), "no shard has body {} in pose {} of split {}", task.pair.body_idx,
                      task.pair.pose_idx, task.split);
        DeformationSet& shard = shards[found->second.first];
        const std::size_t place = found->second.second;
        merged.pairs.push_back(task.pair);
        merged.pair_splits.push_back(task.split);
        merged.vertices.push_back(std::move(shard.vertices[place]));
        for (const auto& [name, values] : shard.statistics) merged.statistics[name].push_back(values[place]);
    }
    require_input(tasks.size() == places.size(), "the shards have {} samples, the splits {}", places.size(),
                  tasks.size());
    return merged;
}

SimulationSummary summarize_simulation(const DeformationSet& set)
{
    require(set.size() > 0, "there are no samples to summarize");
    SimulationSummary summary;
    summary.samples = set.size();
    std::vector<double> iterations = set.statistics.at("iterations");
    summary.converged_share = mean(set.statistics.at("converged"));
    summary.iterations_mean = mean(iterations);
    std::nth_element(iterations.begin(), iterations.begin() + set.size() / 2, iterations.end());
    summary.iterations_median = iterations[static_cast<std::size_t>(set.size() / 2)];
    summary.seconds_mean = mean(set.statistics.at("seconds"));
    summary.inverted_prisms_mean = mean(set.statistics.at("inverted_prisms"));
    const std::vector<double>& residuals = set.statistics.at("residual_relative");
    summary.residual_relative_max = *std::max_element(residuals.begin(), residuals.end());
    for (const double steps : set.statistics.at("load_steps")) summary.load_stepped += steps > 0;
    return summary;
}

}  // namespace ndg
