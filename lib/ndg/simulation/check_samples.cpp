// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/hash.h"
#include "ndg/core/progress.h"
#include "ndg/simulation/sample_parts.h"
#include "ndg/simulation/sample_shards.h"
#include "ndg/io/h5.h"
#include "ndg/io/h5_virtual.h"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <map>
#include <string_view>
#include <tuple>

namespace ndg {

namespace {

namespace fs = std::filesystem;

using PairKey = std::tuple<std::string, int, int>;

std::string text_of(const PairKey& key)
{
    const auto& [split, body_idx, pose_idx] = key;
    return fmt::format("body {} in pose {} of split {}", body_idx, pose_idx, split);
}

/// Defects of one kind: the first in words, the others counted.
class Defects {
public:
    explicit Defects(const std::string& path) : path_(path) {}

    void add(const std::string& kind, const std::string& sentence)
    {
        if (counts_[kind]++ == 0) first_.emplace_back(kind, sentence);
    }
    std::vector<std::string> sentences() const
    {
        std::vector<std::string> sentences;
        for (const auto& [kind, sentence] : first_) {
            const int more = counts_.at(kind) - 1;
            sentences.push_back(
                fmt::format("{}: {}{}", path_, sentence, more == 0 ? "" : fmt::format(", and {} more like it", more)));
        }
        return sentences;
    }

private:
    std::string path_;
    std::map<std::string, int> counts_;
    std::vector<std::pair<std::string, std::string>> first_;
};

/// Every pair of the splits once and no other, the failures among them.
void check_pairs(const DeformationSet& set, const Splits& splits, Defects& defects)
{
    std::map<PairKey, int> counts;
    for (std::size_t i = 0; i < set.pairs.size(); ++i) {
        const PairKey key{set.pair_splits[i], set.pairs[i].body_idx, set.pairs[i].pose_idx};
        if (++counts[key] == 2) defects.add("doubled", text_of(key) + " stands in it twice");
    }
    for (const FailedSample& failure : set.failures) {
        const PairKey key{failure.split, failure.pair.body_idx, failure.pair.pose_idx};
        if (++counts[key] == 2) defects.add("doubled", text_of(key) + " stands in it twice");
    }
    for (const auto& [split, pairs] : splits.pairs) {
        for (const SamplePair& pair : pairs) {
            const PairKey key{split, pair.body_idx, pair.pose_idx};
            if (counts.erase(key) == 0) defects.add("missing", text_of(key) + " is missing");
        }
    }
    for (const auto& [key, count] : counts) defects.add("foreign", text_of(key) + " is no pair of the splits");
}

void check_statistics(const DeformationSet& set, Defects& defects)
{
    for (const std::string& name : simulation_statistics()) {
        if (set.statistics.count(name) == 0) defects.add("statistic", "statistic " + name + " is missing");
    }
    if (set.stop_reasons.empty() && set.size() > 0) defects.add("statistic", "the stop reasons are missing");
}

void check_vertices(const DeformationSet& set, Defects& defects)
{
    Progress progress("checking", static_cast<std::size_t>(set.size()));
    std::map<std::string, int> seen;
    for (int i = 0; i < set.size(); ++i) {
        const SamplePair& pair = set.pairs[static_cast<std::size_t>(i)];
        try {
            const std::vector<float> sample = set.coordinates(i);
            const std::string_view bytes(reinterpret_cast<const char*>(sample.data()), sample.size() * sizeof(float));
            const auto [earlier, is_new] = seen.emplace(sha256(bytes), i);
            if (!is_new) {
                const SamplePair& other = set.pairs[static_cast<std::size_t>(earlier->second)];
                defects.add("alike", fmt::format("body {} in pose {} has the same vertices as body {} in pose {}",
                                                 pair.body_idx, pair.pose_idx, other.body_idx, other.pose_idx));
            }
        } catch (const InputError& error) {
            defects.add("damaged", fmt::format("sample {} (body {}, pose {}) is damaged ({})", i, pair.body_idx,
                                               pair.pose_idx, error.what()));
        }
        progress.advance();
    }
}

/// Name of each input's file -> its hash, as the dataset states them.
std::map<std::string, std::string> stated_hashes(const std::string& path)
{
    std::map<std::string, std::string> hashes;
    for (const auto& [name, value] : list_h5(path).attributes) {
        if (name != "inputs") continue;
        const nlohmann::json inputs = nlohmann::json::parse(value, nullptr, false);
        for (const auto& input : inputs) {
            if (!input.is_object() || !input.contains("path") || !input.contains("sha256")) continue;
            hashes[fs::path(input["path"].get<std::string>()).filename().string()] = input["sha256"];
        }
    }
    return hashes;
}

/// The files of a virtual dataset.
void check_sources(const std::string& path, const DeformationSet& set, Defects& defects)
{
    const std::vector<std::string> sources = virtual_sources(path, "/deformations/vertices");
    if (sources.empty()) return;
    const std::map<std::string, std::string> hashes = stated_hashes(path);
    const auto key = set.attributes.find("simulation_key");
    for (const std::string& source : sources) {
        const std::string source_path = (fs::path(path).parent_path() / source).string();
        const auto hash = hashes.find(fs::path(source).filename().string());
        if (hash == hashes.end() || hash->second != sha256_path(source_path)) {
            defects.add("changed", fmt::format("{} is not the file that was merged", source_path));
        }
        try {
            const DeformationSet shard = open_deformations(source_path, set.num_volume_vertices);
            const auto shard_key = shard.attributes.find("simulation_key");
            const bool same =
                key != set.attributes.end() && shard_key != shard.attributes.end() && shard_key->second == key->second;
            if (!same) {
                defects.add("key", fmt::format("{} was made by another program version, from other inputs or with "
                                               "other options than the dataset states",
                                               source_path));
            }
        } catch (const InputError& error) {
            defects.add("unreadable", fmt::format("one of its shards cannot be read ({})", error.what()));
        }
    }
}

}  // namespace

std::vector<std::string> check_dataset(const std::string& dataset, const Splits& splits)
{
    DeformationSet set;
    try {
        set = open_deformations(dataset);
    } catch (const InputError& error) {
        return {error.what()};
    }
    Defects defects(dataset);
    check_pairs(set, splits, defects);
    check_statistics(set, defects);
    check_sources(dataset, set, defects);
    check_vertices(set, defects);
    return defects.sentences();
}

}  // namespace ndg
