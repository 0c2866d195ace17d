// SPDX-License-Identifier: Apache-2.0
#include "ndg/simulation/simulate.h"

#include "ndg/core/error.h"
#include "ndg/core/log.h"
#include "ndg/core/stopwatch.h"
#include "ndg/dataset/run_batch.h"
#include "ndg/simulation/sample_part.h"
#include "ndg/simulation/simulation_key.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

namespace ndg {

namespace {

/// Throws Error for a solve that left the finite numbers: it is no sample, and its numbers could not even be stored.
SamplePart make_part(const SimulationResult& result, double seconds)
{
    SamplePart part;
    part.vertices.resize(result.vertices.size());
    Eigen::Map<RowMatrixF>(part.vertices.data(), result.vertices.rows(), 3) = result.vertices.cast<float>();
    part.stop_reason = describe(result.newton.stop);
    part.statistics = {{"energy_joule", result.newton.energy_joule},
                       {"residual_newton", result.newton.residual_newton},
                       {"residual_relative", result.newton.residual_relative},
                       {"iterations", result.newton.iterations},
                       {"converged", result.newton.converged()},
                       {"load_steps", result.load_steps},
                       {"inverted_prisms", result.inverted_prisms.by_volume},
                       {"corner_inverted_prisms", result.inverted_prisms.at_corners},
                       {intersecting_triangles_name, result.intersecting_triangles},
                       {"seconds", seconds}};
    for (std::size_t j = 0; j < result.volume_changes.size(); ++j) {
        part.statistics[volume_change_name(flesh_joint_names()[j])] = result.volume_changes[j];
    }
    bool finite = result.vertices.allFinite();
    for (const auto& [name, value] : part.statistics) finite = finite && std::isfinite(value);
    require(finite, "the result is not finite: Newton's method {} after {} iterations", part.stop_reason,
            result.newton.iterations);
    return part;
}

/// The simulations of one thread, one after the other.
class Worker {
public:
    Worker(const BodyPoser& poser, const BodySet& bodies, const PoseSet& poses, const SimulationOptions& options)
        : bodies_(bodies), poses_(poses), simulator_(poser, options)
    {
    }

    SamplePart simulate(const SamplePair& pair)
    {
        // Processor time, so that a busy machine does not show in the statistics.
        const double start = thread_seconds();
        if (pair.body_idx != body_idx_) {
            body_idx_ = -1;
            simulator_.set_body(bodies_.bodies[pair.body_idx]);
            body_idx_ = pair.body_idx;
        }
        const SimulationResult result = simulator_.simulate(poses_.poses[pair.pose_idx]);
        return make_part(result, thread_seconds() - start);
    }

private:
    const BodySet& bodies_;
    const PoseSet& poses_;
    Simulator simulator_;
    int body_idx_ = -1;
};

std::string label(const SampleTask& task)
{
    return fmt::format("sample {} ({})", task.sample_idx, describe(task.pair));
}

BatchItem batch_item(const SampleTask& task)
{
    return {fmt::format("{:06d}", task.sample_idx), describe(task.pair), label(task)};
}

void report_trouble(const SampleTask& task, const SamplePart& part, bool contact)
{
    if (const double left = part.statistics.at(intersecting_triangles_name); contact && left > 0) {
        log_warning("{}: {:.0f} skin triangles intersect in spite of contact", label(task), left);
    }
    if (part.statistics.at("converged") != 0) return;
    log_warning("{} did not converge: Newton's method {} at a relative residual of {:.1e} after {} iterations",
                label(task), part.stop_reason, part.statistics.at("residual_relative"),
                part.statistics.at("iterations"));
}

/// Writes the parts to `output`, holding one at a time.
void collect(const std::vector<SampleTask>& tasks, const PartStore& store, DeformationSet set,
             const std::string& output, const Provenance& provenance)
{
    SamplePart part;
    const auto read = [&](const H5Reader& file) { part = read_sample(file, set.num_volume_vertices); };
    std::vector<BatchItem> stored;
    for (const SampleTask& task : tasks) {
        const BatchItem item = batch_item(task);
        if (const std::string failure = store.read(item, read); !failure.empty()) {
            set.failures.push_back({task.pair, task.split, failure});
            continue;
        }
        stored.push_back(item);
        set.pairs.push_back(task.pair);
        set.pair_splits.push_back(task.split);
        set.stop_reasons.push_back(part.stop_reason);
        for (const auto& [name, value] : part.statistics) set.statistics[name].push_back(value);
    }
    DeformationWriter writer(output, set, provenance);
    for (int i = 0; i < set.size(); ++i) {
        store.read(stored[i], read);
        writer.write(i, part.vertices);
    }
    writer.commit();
}

double mean(const std::vector<double>& values)
{
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace

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
    check_options(options);
    for (const SampleTask& task : tasks) require_pair(task.pair, bodies.bodies.size(), poses.poses.size());
    const std::string key = simulation_key(options, provenance);
    const int num_vertices = body_template.num_volume_vertices();
    if (!force && holds_samples(output, key, tasks)) {
        log_info("{} holds all {} samples already", output, tasks.size());
        // A run killed after its last step may have left its parts.
        if (parts_status(output)) PartStore(output, sample_parts, key, true).remove();
        return open_deformations(output);
    }
    const PartStore store(output, sample_parts, key, force);
    std::vector<SampleTask> ordered = tasks;  // bodies together, so that each is set up once
    std::stable_sort(ordered.begin(), ordered.end(),
                     [](const SampleTask& a, const SampleTask& b) { return a.pair.body_idx < b.pair.body_idx; });
    Batch batch;
    batch.task = "simulating";
    for (const SampleTask& task : ordered) batch.items.push_back(batch_item(task));
    batch.read = [&](const H5Reader& file) { read_sample(file, num_vertices); };
    const BodyPoser poser(body_template, options.posing);
    batch.make_worker = [&] {
        const auto worker = std::make_shared<Worker>(poser, bodies, poses, options);
        return [worker, &ordered, &options](int item_idx) -> PartWriter {
            const SamplePart part = worker->simulate(ordered[item_idx].pair);
            report_trouble(ordered[item_idx], part, options.contact.contact);
            return [part](H5Writer& file) { write_sample(file, part); };
        };
    };
    run_batch(store, batch, stop);

    DeformationSet head;
    head.method = "FEM";
    head.posing = options.posing;
    head.num_volume_vertices = num_vertices;
    head.attributes = {{sample_key_attribute, key}, {"convergence_criterion", convergence_text(options)}};
    collect(tasks, store, head, output, provenance);
    store.remove();
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
    summary.iterations_median = iterations[set.size() / 2];
    summary.seconds_mean = mean(statistic("seconds"));
    const auto count = [&](const std::string& name) {
        const std::vector<double>& values = statistic(name);
        return CountSummary{mean(values),
                            static_cast<double>(std::count(values.begin(), values.end(), 0.0)) / set.size(),
                            *std::max_element(values.begin(), values.end())};
    };
    summary.inverted_prisms = count("inverted_prisms");
    summary.corner_inverted_prisms = count("corner_inverted_prisms");
    summary.intersecting_triangles = count(intersecting_triangles_name);
    // Left and right together.
    for (const std::string joint : {"knee", "hip", "shoulder"}) {
        std::vector<double> changes;
        for (const std::string side : {"left_", "right_"}) {
            const std::vector<double>& of_side = statistic(volume_change_name(side + joint));
            changes.insert(changes.end(), of_side.begin(), of_side.end());
        }
        summary.volume_changes.push_back({joint, mean(changes), *std::min_element(changes.begin(), changes.end()),
                                          *std::max_element(changes.begin(), changes.end())});
    }
    const std::vector<double>& residuals = statistic("residual_relative");
    summary.residual_relative_max = *std::max_element(residuals.begin(), residuals.end());
    for (const double steps : statistic("load_steps")) summary.load_stepped += steps > 0;
    return summary;
}

std::string simulation_report(const SimulationSummary& summary, const DeformationSet& set)
{
    const std::string criterion = set.attribute("convergence_criterion");
    const auto counted = [](const char* what, const CountSummary& count) {
        return fmt::format("{:.2f} {} a sample, none in {:.2f} %, {:.0f} at most\n", count.mean, what,
                           100 * count.without_share, count.max);
    };
    std::string text = fmt::format(
        "{} samples, {} failed, {:.2f} % converged{}\n"
        "iterations: mean {:.1f}, median {:.0f}; {} in load steps; {:.2f} core-seconds a sample\n",
        summary.samples, summary.failed, 100 * summary.converged_share, criterion.empty() ? "" : " (" + criterion + ")",
        summary.iterations_mean, summary.iterations_median, summary.load_stepped, summary.seconds_mean);
    text += counted("inverted prisms", summary.inverted_prisms);
    text += counted("prisms inverted at a corner", summary.corner_inverted_prisms);
    text += counted("intersecting skin triangles", summary.intersecting_triangles);
    std::vector<std::string> changes;
    for (const VolumeChangeSummary& change : summary.volume_changes) {
        changes.push_back(fmt::format("{} {:+.1f} % ({:+.1f} to {:+.1f})", change.joint, 100 * change.mean,
                                      100 * change.min, 100 * change.max));
    }
    return text + fmt::format("volume of the flesh at the joints: {}\n", fmt::join(changes, ", "));
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
