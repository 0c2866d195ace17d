// SPDX-License-Identifier: Apache-2.0
#include "ndg/fem/simulate.h"

#include "ndg/core/error.h"
#include "ndg/core/hash.h"
#include "ndg/core/log.h"
#include "ndg/core/progress.h"
#include "ndg/core/stopwatch.h"
#include "ndg/core/threads.h"
#include "ndg/fem/sample_parts.h"

#include <omp.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <exception>
#include <filesystem>
#include <memory>
#include <mutex>
#include <numeric>
#include <set>
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
SamplePart make_part(const SamplePair& pair, const SimulationResult& result, double seconds)
{
    SamplePart part;
    part.pair = pair;
    part.vertices.resize(static_cast<std::size_t>(result.vertices.size()));
    Eigen::Map<Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>>(part.vertices.data(), result.vertices.rows(),
                                                                         3) = result.vertices.cast<float>();
    part.stop_reason = describe(result.newton.stop);
    part.statistics = {{"energy_joule", result.newton.energy_joule},
                       {"residual_newton", result.newton.residual_newton},
                       {"residual_relative", result.newton.residual_relative},
                       {"iterations", result.newton.iterations},
                       {"converged", result.newton.converged()},
                       {"load_steps", result.load_steps},
                       {"inverted_prisms", result.inverted_prisms},
                       {"seconds", seconds}};
    // A solve that left the finite numbers is no sample; its numbers could not even be stored.
    bool finite = result.vertices.allFinite();
    for (const auto& [name, value] : part.statistics) finite = finite && std::isfinite(value);
    if (!finite) {
        part.failure = fmt::format("the result is not finite: Newton's method {} after {} iterations", part.stop_reason,
                                   result.newton.iterations);
        part.statistics.clear();
        part.vertices.clear();
    }
    return part;
}

/// The simulations of one thread, one after the other.
class Worker {
public:
    Worker(const Template& body_template, const BodySet& bodies, const PoseSet& poses, const SimulationOptions& options)
        : bodies_(bodies), poses_(poses), simulator_(body_template, options)
    {
    }

    /// What goes wrong within the sample is its own failure; wrong input is everybody's.
    SamplePart simulate(const SamplePair& pair)
    {
        const double start = thread_seconds();
        try {
            if (pair.body_idx != body_idx_) {
                body_idx_ = -1;
                simulator_.set_body(bodies_.bodies[static_cast<std::size_t>(pair.body_idx)]);
                body_idx_ = pair.body_idx;
            }
            const SimulationResult result = simulator_.simulate(poses_.poses[static_cast<std::size_t>(pair.pose_idx)]);
            return make_part(pair, result, thread_seconds() - start);
        } catch (const InputError&) {
            throw;
        } catch (const Error& error) {
            SamplePart part;
            part.pair = pair;
            part.failure = error.what();
            return part;
        }
    }

private:
    const BodySet& bodies_;
    const PoseSet& poses_;
    Simulator simulator_;
    int body_idx_ = -1;
};

void report_trouble(const SampleTask& task, const SamplePart& part)
{
    if (!part.failure.empty()) {
        log_warning("sample {} (body {}, pose {}) failed: {}", task.sample_idx, task.pair.body_idx, task.pair.pose_idx,
                    part.failure);
    } else if (part.statistics.at("converged") == 0) {
        log_warning(
            "sample {} (body {}, pose {}) did not converge: Newton's method {} at a relative residual of {:.1e} "
            "after {} iterations",
            task.sample_idx, task.pair.body_idx, task.pair.pose_idx, part.stop_reason,
            part.statistics.at("residual_relative"), part.statistics.at("iterations"));
    }
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

/// Writes the parts to `output`, holding one at a time.
void collect(const std::vector<SampleTask>& tasks, const PartFolder& parts, DeformationSet set,
             const std::string& output, const Provenance& provenance)
{
    const auto read = [&](const SampleTask& task) {
        std::optional<SamplePart> part = parts.read(task.sample_idx, task.pair);
        require(part.has_value(), "{}: the part of sample {} cannot be read back", parts.path(), task.sample_idx);
        return std::move(*part);
    };
    std::vector<SampleTask> stored;
    for (const SampleTask& task : tasks) {
        const SamplePart part = read(task);
        if (!part.failure.empty()) {
            set.failures.push_back({task.pair, task.split, part.failure});
            continue;
        }
        stored.push_back(task);
        set.pairs.push_back(task.pair);
        set.pair_splits.push_back(task.split);
        set.stop_reasons.push_back(part.stop_reason);
        for (const auto& [name, value] : part.statistics) set.statistics[name].push_back(value);
    }
    DeformationWriter writer(output, set, provenance);
    for (int i = 0; i < set.size(); ++i) writer.write(i, read(stored[i]).vertices);
    writer.commit();
}

/// Whether `output` holds these tasks already. Throws InputError when it holds something else.
bool is_complete(const std::string& output, const std::string& key, const std::vector<SampleTask>& tasks)
{
    if (!std::filesystem::exists(output)) return false;
    const DeformationSet set = open_deformations(output);
    const auto found = set.attributes.find("simulation_key");
    require_input(found != set.attributes.end() && found->second == key,
                  "{}: was made by another program version, from other inputs or with other options; --force replaces "
                  "it",
                  output);
    std::set<std::tuple<std::string, int, int>> stored;
    for (std::size_t i = 0; i < set.pairs.size(); ++i) {
        stored.emplace(set.pair_splits[i], set.pairs[i].body_idx, set.pairs[i].pose_idx);
    }
    for (const FailedSample& failure : set.failures) {
        stored.emplace(failure.split, failure.pair.body_idx, failure.pair.pose_idx);
    }
    bool same = stored.size() == tasks.size();
    for (const SampleTask& task : tasks) {
        same = same && stored.count({task.split, task.pair.body_idx, task.pair.pose_idx}) == 1;
    }
    require_input(same, "{}: holds the {} samples of another shard; --force replaces it", output, stored.size());
    return true;
}

/// The tool's parameters but those that choose and judge samples: whatever else is configured may change them.
std::string sample_config(const std::string& config_json)
{
    nlohmann::json config = nlohmann::json::parse(config_json);
    for (nlohmann::json& section : config) {
        if (!section.is_object()) continue;
        for (const char* key : {"shard", "replay", "min_converged", "seed"}) section.erase(key);
    }
    return config.dump();
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
    std::string text = fmt::format("{} {}\n{} {} {} {} {} {} {}\n{} {} {} {}\n", project_version(), project_commit(),
                                   material.energy, material.young_muscle_pascal, material.young_fat_pascal,
                                   material.poisson_ratio, material.flesh_stiffness, material.stretch_stiffness,
                                   material.bend_stiffness, newton.relative_tolerance, newton.absolute_tolerance_newton,
                                   newton.max_iterations, options.load_steps);
    for (const Provenance::Input& input : provenance.inputs) text += input.sha256 + "\n";
    return sha256(text + sample_config(provenance.config_json));
}

std::string convergence_text(const SimulationOptions& options)
{
    return fmt::format("out-of-balance force <= {:g} of all element forces, or <= {:g} N",
                       options.newton.relative_tolerance, options.newton.absolute_tolerance_newton);
}

DeformationSet simulate_samples(const Template& body_template, const BodySet& bodies, const PoseSet& poses,
                                const std::vector<SampleTask>& tasks, const SimulationOptions& options,
                                const std::string& output, const Provenance& provenance,
                                const std::function<bool()>& stop, bool force)
{
    options.check();
    for (const SampleTask& task : tasks) require_pair(task.pair, bodies.bodies.size(), poses.poses.size());
    const std::string key = simulation_key(options, provenance);
    if (!force && is_complete(output, key, tasks)) {
        log_info("{} holds all {} samples already", output, tasks.size());
        // A run killed after its last step may have left its parts.
        if (parts_status(output)) PartFolder(output, key, body_template.num_volume_vertices(), true).remove();
        return open_deformations(output);
    }
    const PartFolder parts(output, key, body_template.num_volume_vertices(), force);
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
        std::unique_ptr<Worker> worker;
        while (!stopped) {
            if (next >= open.size()) break;
            if (stop()) stopped = true;
            const std::size_t place = stopped ? open.size() : next++;
            if (place >= open.size()) break;
            const SampleTask& task = open[place];
            if (!worker) worker = std::make_unique<Worker>(body_template, bodies, poses, options);
            const SamplePart part = worker->simulate(task.pair);
            report_trouble(task, part);
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
    DeformationSet head;
    head.method = "FEM";
    head.num_volume_vertices = body_template.num_volume_vertices();
    head.attributes = {{"simulation_key", key}, {"convergence_criterion", convergence_text(options)}};
    collect(tasks, parts, head, output, provenance);
    parts.remove();
    return open_deformations(output);
}

SimulationSummary summarize_simulation(const DeformationSet& set)
{
    SimulationSummary summary;
    summary.samples = set.size();
    summary.failed = static_cast<int>(set.failures.size());
    if (set.size() == 0) return summary;
    const auto statistic = [&](const std::string& name) -> const std::vector<double>& {
        const auto found = set.statistics.find(name);
        require_input(found != set.statistics.end(), "the {} samples have no statistic {}, so they were not simulated",
                      set.method, name);
        return found->second;
    };
    std::vector<double> iterations = statistic("iterations");
    summary.converged_share = mean(statistic("converged")) * set.size() / (set.size() + summary.failed);
    summary.iterations_mean = mean(iterations);
    std::nth_element(iterations.begin(), iterations.begin() + set.size() / 2, iterations.end());
    summary.iterations_median = iterations[static_cast<std::size_t>(set.size() / 2)];
    summary.seconds_mean = mean(statistic("seconds"));
    const std::vector<double>& inverted = statistic("inverted_prisms");
    summary.inverted_prisms_mean = mean(inverted);
    summary.without_inverted_share =
        static_cast<double>(std::count(inverted.begin(), inverted.end(), 0.0)) / set.size();
    const std::vector<double>& residuals = statistic("residual_relative");
    summary.residual_relative_max = *std::max_element(residuals.begin(), residuals.end());
    for (const double steps : statistic("load_steps")) summary.load_stepped += steps > 0;
    return summary;
}

std::string simulation_report(const SimulationSummary& summary, const DeformationSet& set)
{
    const auto criterion = set.attributes.find("convergence_criterion");
    return fmt::format(
        "{} samples, {} failed, {:.2f} % converged{}\n"
        "iterations: mean {:.1f}, median {:.0f}; {} in load steps; {:.2f} core-seconds a sample; "
        "{:.2f} inverted prisms a sample, none in {:.2f} %\n",
        summary.samples, summary.failed, 100 * summary.converged_share,
        criterion == set.attributes.end() ? "" : " (" + criterion->second + ")", summary.iterations_mean,
        summary.iterations_median, summary.load_stepped, summary.seconds_mean, summary.inverted_prisms_mean,
        100 * summary.without_inverted_share);
}

void require_converged(const SimulationSummary& summary, double min_converged)
{
    if (summary.converged_share < min_converged) {
        throw QualityError(
            fmt::format("{:.2f} % of the samples converged, fewer than {:.2f} %; largest relative "
                        "residual {:.1e}",
                        100 * summary.converged_share, 100 * min_converged, summary.residual_relative_max));
    }
}

}  // namespace ndg
