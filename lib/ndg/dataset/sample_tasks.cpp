// SPDX-License-Identifier: Apache-2.0
#include "ndg/dataset/sample_tasks.h"

#include "ndg/core/error.h"
#include "ndg/dataset/deformation_file.h"

#include <cstdio>
#include <filesystem>
#include <set>

namespace ndg {

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

bool holds_samples(const std::string& output, const std::string& key, const std::vector<SampleTask>& tasks)
{
    if (!std::filesystem::exists(output)) return false;
    const DeformationSet set = open_deformations(output);
    require_input(
        set.attribute(sample_key_attribute) == key,
        "{}: was made by another version of the method, from other inputs or with other options; --force replaces "
        "it",
        output);
    std::set<SampleKey> stored;
    for (int i = 0; i < set.size(); ++i) stored.insert(set.key(i));
    for (const FailedSample& failure : set.failures) stored.insert({failure.split, failure.pair});
    bool same = stored.size() == tasks.size();
    for (const SampleTask& task : tasks) same = same && stored.count(task.key()) == 1;
    require_input(same, "{}: holds the {} samples of another shard; --force replaces it", output, stored.size());
    return true;
}

}  // namespace ndg
