// SPDX-License-Identifier: Apache-2.0
#include "ndg/dataset/shards.h"

#include "ndg/core/error.h"
#include "ndg/core/hash.h"
#include "ndg/dataset/part_store.h"
#include "ndg/io/h5_virtual.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>

namespace ndg {

namespace {

namespace fs = std::filesystem;

std::string shard_folder(const std::string& dataset)
{
    const fs::path path(dataset);
    return (path.parent_path() / (path.extension() == ".h5" ? path.stem() : path.filename())).string() + ".shards";
}

/// Number of pairs of a shard; a shard may have none.
int count_tasks(const Splits& splits, const Shard& shard)
{
    int count = 0;
    for (const auto& [split, pairs] : splits.pairs) count += static_cast<int>(pairs.size());
    return count / shard.count + (shard.index < count % shard.count ? 1 : 0);
}

ShardStatus shard_status(const std::string& dataset, const Splits& splits, const Shard& shard)
{
    ShardStatus status;
    status.shard = shard;
    status.path = shard_path(dataset, shard);
    status.total = count_tasks(splits, shard);
    if (const std::optional<PartsStatus> parts = parts_status(status.path)) {
        status.state = parts->running ? ShardStatus::running : ShardStatus::stopped;
        status.done = parts->done;
        status.failed = parts->failed;
        status.process = parts->process;
        status.rate_hertz = parts->rate_hertz;
    } else if (fs::exists(status.path)) {
        const DeformationSet set = open_deformations(status.path);
        status.done = set.size();
        status.failed = static_cast<int>(set.failures.size());
        require_input(status.done + status.failed == status.total,
                      "{}: holds {} samples, the splits give this shard {}", status.path, status.done + status.failed,
                      status.total);
        status.state = ShardStatus::complete;
    } else if (status.total == 0) {
        status.state = ShardStatus::complete;
    }
    return status;
}

std::string time_text(double seconds)
{
    const auto whole = static_cast<long long>(seconds + 0.5);
    return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

/// Shards that are complete, opened, and where each of their samples and failures stands.
struct OpenShards {
    std::vector<std::string> paths;
    std::vector<DeformationSet> sets;
    std::map<SampleKey, std::pair<std::size_t, std::size_t>> samples, failures;
};

OpenShards open_shards(const std::string& dataset, const Splits& splits)
{
    const int count = found_shard_count(dataset);
    require_input(count > 0, "{}: there are no shards in {}", dataset, shard_folder(dataset));
    OpenShards shards;
    for (const ShardStatus& status : dataset_status(dataset, splits, count)) {
        require_input(status.state == ShardStatus::complete, "{}: shard {}/{} is not complete ({} of {} samples)",
                      status.path, status.shard.index, count, status.done + status.failed, status.total);
        if (status.total == 0) continue;
        DeformationSet set = open_deformations(status.path);
        set.file.reset();  // the lists are enough, and so many files cannot be open at once
        const std::size_t place = shards.sets.size();
        for (int i = 0; i < set.size(); ++i) {
            require_input(shards.samples.emplace(set.key(i), std::pair{place, i}).second,
                          "{}: {} stands in another shard already", status.path, describe(set.key(i)));
        }
        for (std::size_t i = 0; i < set.failures.size(); ++i) {
            const FailedSample& failure = set.failures[i];
            shards.failures.emplace(SampleKey{failure.split, failure.pair}, std::pair{place, i});
        }
        shards.paths.push_back(status.path);
        shards.sets.push_back(std::move(set));
        const DeformationSet &first = shards.sets.front(), &last = shards.sets.back();
        require_input(last.num_volume_vertices == first.num_volume_vertices &&
                          last.attribute(sample_key_attribute) == first.attribute(sample_key_attribute),
                      "{}: was made by another version of the method, from other inputs or with other options than {}",
                      shards.paths.back(), shards.paths.front());
    }
    return shards;
}

}  // namespace

std::string shard_path(const std::string& dataset, const Shard& shard)
{
    if (shard.count == 1) return dataset;
    return fmt::format("{}/{:04d}-of-{:04d}.h5", shard_folder(dataset), shard.index, shard.count);
}

int found_shard_count(const std::string& dataset)
{
    int count = 0;
    std::string first;
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(shard_folder(dataset), error)) {
        const std::string name = entry.path().filename().string();
        Shard shard;
        if (std::sscanf(name.c_str(), "%d-of-%d.h5", &shard.index, &shard.count) != 2) continue;
        const std::string whole = fs::path(shard_path(dataset, shard)).filename().string();
        if (name != whole && name != whole + ".parts") continue;
        require_input(count == 0 || shard.count == count,
                      "{}: holds shards of {} and of {}; remove those of one number", shard_folder(dataset),
                      std::min(count, shard.count), std::max(count, shard.count));
        count = shard.count;
    }
    return count;
}

std::vector<ShardStatus> dataset_status(const std::string& dataset, const Splits& splits, int shard_count)
{
    const int found = found_shard_count(dataset);
    require_input(shard_count == 0 || found == 0 || found == shard_count, "{}: holds shards of {}, not of {}",
                  shard_folder(dataset), found, shard_count);
    const int count = std::max({shard_count, found, 1});
    std::vector<ShardStatus> shards;
    for (int i = 0; i < count; ++i) shards.push_back(shard_status(dataset, splits, Shard{i, count}));
    return shards;
}

std::string status_report(const std::vector<ShardStatus>& shards)
{
    int total = 0, done = 0, failed = 0;
    double rate = 0;
    std::map<ShardStatus::State, int> counts;
    std::string unfinished, running;
    for (const ShardStatus& status : shards) {
        total += status.total;
        done += status.done;
        failed += status.failed;
        rate += status.rate_hertz;
        ++counts[status.state];
        if (status.state != ShardStatus::complete) {
            unfinished += fmt::format("{}{}", unfinished.empty() ? "" : ",", status.shard.index);
        }
        if (status.state == ShardStatus::running) {
            running += fmt::format("running     {}/{}: {} of {} samples, {}\n", status.shard.index, status.shard.count,
                                   status.done + status.failed, status.total, status.process);
        }
    }
    const int left = total - done - failed;
    std::string rate_text = "nothing is running";
    if (left == 0) rate_text = "nothing is left";
    if (rate > 0) rate_text = fmt::format("{:.3g}/s, {} left", rate, time_text(left / rate));
    if (rate == 0 && counts[ShardStatus::running] > 0) rate_text = "no sample yet";
    return fmt::format("samples     {} of {} done, {} failed, {} left\n", done, total, failed, left) +
           fmt::format("shards      {}: {} complete, {} running, {} stopped, {} not started\n", shards.size(),
                       counts[ShardStatus::complete], counts[ShardStatus::running], counts[ShardStatus::stopped],
                       counts[ShardStatus::not_started]) +
           running +
           fmt::format("rate        {}\nunfinished  {}\n", rate_text, unfinished.empty() ? "none" : unfinished);
}

DeformationSet merge_shards(const std::string& dataset, const Splits& splits, Provenance provenance, bool force)
{
    require_input(force || !fs::exists(dataset) || !deformation_sources(dataset).empty(),
                  "{}: exists already and holds samples of its own; --force replaces it", dataset);
    const OpenShards shards = open_shards(dataset, splits);
    DeformationSet merged;
    merged.method = shards.sets.front().method;
    merged.posing = shards.sets.front().posing;
    merged.num_volume_vertices = shards.sets.front().num_volume_vertices;
    merged.attributes = shards.sets.front().attributes;
    std::vector<VirtualSource> sources(shards.sets.size());
    std::size_t num_slices = 0;
    for (const SampleTask& task : sample_tasks(splits, Shard{})) {
        const SampleKey key = task.key();
        if (const auto failed = shards.failures.find(key); failed != shards.failures.end()) {
            const auto [shard, place] = failed->second;
            merged.failures.push_back(shards.sets[shard].failures[place]);
            continue;
        }
        const auto found = shards.samples.find(key);
        require_input(found != shards.samples.end(), "{}: no shard has {}", dataset, describe(key));
        const auto [shard, place] = found->second;
        const DeformationSet& set = shards.sets[shard];
        for (int f = 0; f < task.pair.num_frames; ++f) {
            sources[shard].slices.push_back(set.first_slice(static_cast<int>(place)) + f);
            sources[shard].places.push_back(num_slices++);
        }
        merged.pairs.push_back(task.pair);
        merged.pair_splits.push_back(task.split);
        merged.stop_reasons.push_back(set.stop_reasons.empty() ? "" : set.stop_reasons[place]);
        for (const auto& [name, values] : set.statistics) merged.statistics[name].push_back(values[place]);
    }
    const fs::path folder = fs::absolute(dataset).parent_path();
    for (std::size_t i = 0; i < sources.size(); ++i) {
        sources[i].path = fs::absolute(shards.paths[i]).lexically_relative(folder).string();
        sources[i].num_slices = shards.sets[i].num_slices();
        provenance.inputs.push_back({shards.paths[i], sha256_path(shards.paths[i]), ""});
    }
    sources.erase(std::remove_if(sources.begin(), sources.end(),
                                 [](const VirtualSource& source) { return source.places.empty(); }),
                  sources.end());
    link_deformations(dataset, merged, provenance, sources);
    return open_deformations(dataset);
}

}  // namespace ndg
