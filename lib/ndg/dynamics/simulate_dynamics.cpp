// SPDX-License-Identifier: Apache-2.0
#include "ndg/dynamics/simulate_dynamics.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/log.h"
#include "ndg/dataset/run_batch.h"
#include "ndg/motion/resample_poses.h"

#include <algorithm>
#include <filesystem>
#include <numeric>

namespace ndg {

namespace {

const PartKind dynamics_parts = {"ndg-dynamics-part", 1, "blocks of frames"};
const std::string vertices_name = "/block/vertices", times_name = "/block/times", positions_name = "/state/positions",
                  velocities_name = "/state/velocities";

std::string label_of(const DynamicSequence& sequence)
{
    return fmt::format("motion {} (\"{}\")", sequence.index, sequence.name);
}

/// The part that tells that a sequence is done.
BatchItem sequence_item(const DynamicSequence& sequence)
{
    return {fmt::format("motion-{:05d}", sequence.index),
            fmt::format("{} of {} poses", label_of(sequence), sequence.poses.size()), label_of(sequence)};
}

BatchItem block_item(const DynamicSequence& sequence, int block)
{
    BatchItem item = sequence_item(sequence);
    item.file += fmt::format("-block-{:05d}", block);
    item.identity += fmt::format(", block {}", block);
    item.label += fmt::format(", block {}", block);
    return item;
}

void write_block(H5Writer& file, const DynamicBlock& block)
{
    const std::size_t frames = block.times.size(), coordinates = block.vertices[0].size();
    std::vector<float> all;
    all.reserve(frames * coordinates);
    for (const std::vector<float>& frame : block.vertices) all.insert(all.end(), frame.begin(), frame.end());
    file.write(vertices_name, {frames, coordinates / 3, 3}, all.data(), "vertices of the block's frames");
    file.write(times_name, block.times, "s");
    for (const auto& [name, values] : block.statistics) file.write("/statistics/" + name, values, "per frame");
    file.write(positions_name, block.state.positions, "vertices at the last frame, in full", Storage::float64);
    file.write(velocities_name, block.state.velocities, "their velocities, m/s", Storage::float64);
}

DynamicBlock read_block(const H5Reader& file, int num_vertices)
{
    DynamicBlock block;
    block.times = file.read_doubles(times_name);
    const std::vector<std::size_t> expected{block.times.size(), static_cast<std::size_t>(num_vertices), 3};
    require_input(!block.times.empty() && file.shape(vertices_name) == expected,
                  "{}: {} does not hold {} frames of {} vertices", file.path(), vertices_name, block.times.size(),
                  num_vertices);
    for (std::size_t f = 0; f < block.times.size(); ++f) block.vertices.push_back(file.read_slice(vertices_name, f));
    for (const std::string& name : dynamics_statistics()) {
        block.statistics[name] =
            file.read_doubles("/statistics/" + name, static_cast<std::int64_t>(block.times.size()));
    }
    block.state.positions = file.read_matrix(positions_name, num_vertices, 3);
    block.state.velocities = file.read_matrix(velocities_name, num_vertices, 3);
    return block;
}

/// Simulates what of a sequence has not been stored yet, block by block.
void simulate_sequence(const DynamicsRun& run, const DynamicSequence& sequence, const PartStore& store,
                       const std::function<bool()>& stop)
{
    const DynamicActor actor = run.make_actor();
    MotionSimulation simulation(*actor.body, sequence.poses, run.loads, run.options, actor.hook.get());
    std::optional<DynamicState> state;
    for (int b = 0; b < simulation.num_blocks(); ++b) {
        const BatchItem item = block_item(sequence, b);
        DynamicBlock block;
        const auto read = [&](const H5Reader& file) { block = read_block(file, actor.body->num_vertices()); };
        if (store.find(item, read)) {
            state = std::move(block.state);
            continue;
        }
        if (stop()) {
            throw Interrupted(
                fmt::format("interrupted; finished {} are kept in {}, the same command goes on from there",
                            store.kind().items, store.path()));
        }
        block = simulation.run(b, state);
        for (std::size_t f = 0; f < block.times.size(); ++f) {
            if (block.statistics["converged"][f] != 0) continue;
            log_warning("{}: a step to {:.3f} s did not converge, relative residual {:.1e}", label_of(sequence),
                        block.times[f], block.statistics["residual_relative"][f]);
        }
        store.write(item, [&](H5Writer& file) { write_block(file, block); });
        state = std::move(block.state);
    }
}

int num_blocks(const DynamicsRun& run, const DynamicSequence& sequence)
{
    return run.options.num_blocks(run.options.num_frames(sequence.poses.size()));
}

/// Blocks of finished sequences that have been lost or damaged since are made again.
void complete(const DynamicsRun& run, const std::vector<DynamicSequence>& sequences, const PartStore& store,
              const std::function<bool()>& stop)
{
    const int num_vertices = run.make_actor().body->num_vertices();
    for (const DynamicSequence& sequence : sequences) {
        if (!store.read(sequence_item(sequence), [](const H5Reader&) {}).empty()) continue;  // failed
        bool whole = true;
        for (int b = 0; b < num_blocks(run, sequence); ++b) {
            whole &= store.find(block_item(sequence, b), [&](const H5Reader& file) { read_block(file, num_vertices); })
                         .has_value();
        }
        if (!whole) simulate_sequence(run, sequence, store, stop);
    }
}

/// All frames of the sequences that came through, in order, from their parts.
DynamicsSet collect(const DynamicsRun& run, const std::vector<DynamicSequence>& sequences, const PartStore& store,
                    const std::string& key, const std::string& output, const Provenance& provenance)
{
    const DynamicActor actor = run.make_actor();
    const DrivenBody& body = *actor.body;
    DynamicsSet set;
    set.model = run.model;
    set.key = key;
    set.convergence_criterion =
        fmt::format("out-of-balance force <= {:g} of all forces, inertia among them, or <= {:g} N, in every step",
                    run.options.newton.relative_tolerance, run.options.newton.absolute_tolerance_newton);
    set.time_step_seconds = 1 / run.options.step_rate_hertz;
    set.frame_rate_hertz = run.options.frame_rate_hertz;
    set.num_held = body.num_held();
    set.rest = body.rest();
    set.skin_triangles = body.skin_triangles();
    set.others = body.other_surfaces();
    std::vector<BatchItem> blocks;
    DynamicBlock block;
    const auto read = [&](const H5Reader& file) { block = read_block(file, body.num_vertices()); };
    for (const DynamicSequence& sequence : sequences) {
        const std::string failure = store.read(sequence_item(sequence), [](const H5Reader&) {});
        if (!failure.empty()) {
            set.failed_sequences.push_back(sequence.name);
            set.failure_reasons.push_back(failure);
            continue;
        }
        set.sequence_names.push_back(sequence.name);
        set.frame_begin.push_back(set.num_frames());
        const auto last = static_cast<int>(sequence.poses.size()) - 1;
        for (int f = 0; f < run.options.num_frames(sequence.poses.size()); ++f) {
            const int step = std::min(f * run.options.steps_per_frame(), last);
            set.poses.push_back(sequence.poses[static_cast<std::size_t>(step)]);
        }
        for (int b = 0; b < num_blocks(run, sequence); ++b) {
            const BatchItem item = block_item(sequence, b);
            store.read(item, read);
            blocks.push_back(item);
            set.times.insert(set.times.end(), block.times.begin(), block.times.end());
            for (const auto& [name, values] : block.statistics) {
                set.statistics[name].insert(set.statistics[name].end(), values.begin(), values.end());
            }
        }
    }
    require(!set.sequence_names.empty(), "no motion came through: {}", set.failure_reasons[0]);
    DynamicsWriter writer(output, set, provenance);
    int frame = 0;
    for (const BatchItem& item : blocks) {
        store.read(item, read);
        for (const std::vector<float>& vertices : block.vertices) writer.write(frame++, vertices);
    }
    writer.commit();
    return set;
}

/// Whether the set is of these sequences, failed ones among them.
bool holds_all(const DynamicsSet& set, const std::vector<DynamicSequence>& sequences)
{
    std::vector<std::string> found = set.sequence_names, wanted;
    found.insert(found.end(), set.failed_sequences.begin(), set.failed_sequences.end());
    for (const DynamicSequence& sequence : sequences) wanted.push_back(sequence.name);
    std::sort(found.begin(), found.end());
    std::sort(wanted.begin(), wanted.end());
    return found == wanted;
}

}  // namespace

std::vector<DynamicSequence> sequences_of(const PoseSet& poses, const std::vector<std::string>& names, double rate)
{
    for (const std::string& name : names) {
        require_input(std::find(poses.clip_names.begin(), poses.clip_names.end(), name) != poses.clip_names.end(),
                      "there is no motion \"{}\" among the {} clips of the poses", name, poses.clip_names.size());
    }
    std::vector<DynamicSequence> sequences;
    for (std::size_t c = 0; c < poses.clip_names.size(); ++c) {
        if (!names.empty() && std::find(names.begin(), names.end(), poses.clip_names[c]) == names.end()) continue;
        PoseSet clip;
        clip.clip_names = {poses.clip_names[c]};
        clip.clip_frame_rates = {poses.clip_frame_rates[c]};
        for (int p = 0; p < poses.size(); ++p) {
            if (poses.clip_idx[p] != static_cast<int>(c) || poses.is_spliced(p)) continue;
            require_input(clip.frame_idx.empty() || poses.frame_idx[p] > clip.frame_idx.back(),
                          "the poses of clip \"{}\" are no motion: their frames do not ascend", clip.clip_names[0]);
            clip.poses.push_back(poses.poses[p]);
            clip.clip_idx.push_back(0);
            clip.frame_idx.push_back(poses.frame_idx[p]);
        }
        if (clip.size() == 0) continue;
        sequences.push_back({static_cast<int>(sequences.size()), clip.clip_names[0], resample_poses(clip, rate).poses});
    }
    require_input(!sequences.empty(), "the poses hold no motion");
    return sequences;
}

std::vector<DynamicSequence> shard_of(const std::vector<DynamicSequence>& sequences, const Shard& shard)
{
    std::vector<DynamicSequence> mine;
    for (const DynamicSequence& sequence : sequences) {
        if (sequence.index % shard.count == shard.index) mine.push_back(sequence);
    }
    require_input(!mine.empty(), "shard {}/{} of {} motions has none", shard.index, shard.count, sequences.size());
    return mine;
}

DynamicsSet simulate_dynamics(const DynamicsRun& run, const std::vector<DynamicSequence>& sequences,
                              const std::string& output, const Provenance& provenance,
                              const std::function<bool()>& stop, bool force)
{
    check_options(run.options);
    const std::string key = run_key("dynamics", dynamics_method_version,
                                    fmt::format("{} {}", run.model, run.options_key), data_hashes(provenance));
    if (!force && std::filesystem::exists(output)) {
        const DynamicsReader found(output);
        require_input(found.set().key == key && holds_all(found.set(), sequences),
                      "{}: was made from other inputs, of other motions, with other options or by another version of "
                      "the method; --force "
                      "makes it anew",
                      output);
        log_info("{} holds all {} motions already", output, sequences.size());
        if (parts_status(output)) PartStore(output, dynamics_parts, key, true).remove();
        return found.set();
    }
    const PartStore store(output, dynamics_parts, key, force);
    Batch batch;
    batch.task = "simulating";
    for (const DynamicSequence& sequence : sequences) batch.items.push_back(sequence_item(sequence));
    batch.read = [](const H5Reader&) {};
    batch.make_worker = [&] {
        return [&](int item_idx) -> PartWriter {
            simulate_sequence(run, sequences[static_cast<std::size_t>(item_idx)], store, stop);
            return [](H5Writer&) {};
        };
    };
    run_batch(store, batch, stop);
    complete(run, sequences, store, stop);
    DynamicsSet set = collect(run, sequences, store, key, output, provenance);
    store.remove();
    return set;
}

std::string dynamics_report(const DynamicsSet& set)
{
    const auto sum = [&](const char* name) {
        const std::vector<double>& values = set.statistics.at(name);
        return std::accumulate(values.begin(), values.end(), 0.0);
    };
    const double frames = set.num_frames();
    const double steps_per_frame = 1 / (set.time_step_seconds * set.frame_rate_hertz);
    const double steps = std::max(1.0, (frames - static_cast<double>(set.sequence_names.size())) * steps_per_frame);
    const std::vector<double>& residuals = set.statistics.at("residual_newton");
    std::string text = fmt::format(
        "{} motions, {} frames of {} vertices, {} failed; {:.2f} % of the frames converged, at most {:.1e} N out of "
        "balance\n{:.2f} iterations, {:.2f} factorizations and {:.1f} CG a step; {:.3f} core-seconds a step\n",
        set.sequence_names.size(), frames, set.num_vertices(), set.failed_sequences.size(),
        100 * sum("converged") / frames, *std::max_element(residuals.begin(), residuals.end()),
        sum("iterations") / steps, sum("factorizations") / steps, sum("cg_iterations") / steps, sum("seconds") / steps);
    for (std::size_t i = 0; i < set.failed_sequences.size(); ++i) {
        text += fmt::format("{} failed: {}\n", set.failed_sequences[i], set.failure_reasons[i]);
    }
    return text;
}

void require_converged(const DynamicsSet& set, double min_converged)
{
    const std::vector<double>& converged = set.statistics.at("converged");
    const double share =
        std::accumulate(converged.begin(), converged.end(), 0.0) / static_cast<double>(converged.size());
    if (share < min_converged) {
        throw QualityError(
            fmt::format("{:.2f} % of the frames converged, fewer than {:.2f} %", 100 * share, 100 * min_converged));
    }
    if (!set.failed_sequences.empty()) {
        throw QualityError(fmt::format("motion \"{}\" failed: {}", set.failed_sequences[0], set.failure_reasons[0]));
    }
}

}  // namespace ndg
