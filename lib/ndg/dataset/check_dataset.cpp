// SPDX-License-Identifier: Apache-2.0
#include "ndg/dataset/check_dataset.h"

#include "ndg/core/error.h"
#include "ndg/core/hash.h"
#include "ndg/core/progress.h"
#include "ndg/dataset/deformation_file.h"
#include "ndg/dataset/sample_tasks.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <string_view>

namespace ndg {

namespace {

namespace fs = std::filesystem;

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
    std::map<SampleKey, int> counts;
    const auto count = [&](const SampleKey& key) {
        if (++counts[key] == 2) defects.add("doubled", describe(key) + " stands in it twice");
    };
    for (int i = 0; i < set.size(); ++i) count(set.key(i));
    for (const FailedSample& failure : set.failures) count({failure.split, failure.pair});
    for (const auto& [split, pairs] : splits.pairs) {
        for (const SamplePair& pair : pairs) {
            const SampleKey key{split, pair};
            if (counts.erase(key) == 0) defects.add("missing", describe(key) + " is missing");
        }
    }
    for (const auto& [key, number] : counts) defects.add("foreign", describe(key) + " is no pair of the splits");
}

void check_statistics(const DeformationSet& set, const std::vector<std::string>& statistics, Defects& defects)
{
    for (const std::string& name : statistics) {
        if (set.statistics.count(name) == 0) defects.add("statistic", "statistic " + name + " is missing");
    }
    if (set.stop_reasons.empty() && set.size() > 0) defects.add("statistic", "the stop reasons are missing");
}

void check_vertices(const DeformationSet& set, Defects& defects)
{
    Progress progress("checking", static_cast<std::size_t>(set.size()));
    std::map<std::string, int> seen;
    for (int i = 0; i < set.size(); ++i) {
        const std::string sample = describe(set.pairs[i]);
        try {
            const std::vector<float> vertices = set.coordinates(i);
            const std::string_view bytes(reinterpret_cast<const char*>(vertices.data()),
                                         vertices.size() * sizeof(float));
            const auto [earlier, is_new] = seen.emplace(sha256(bytes), i);
            if (!is_new) {
                defects.add("alike", fmt::format("{} has the same vertices as {}", sample,
                                                 describe(set.pairs[earlier->second])));
            }
        } catch (const InputError& error) {
            defects.add("damaged", fmt::format("sample {} ({}) is damaged ({})", i, sample, error.what()));
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
    const std::vector<std::string> sources = deformation_sources(path);
    if (sources.empty()) return;
    const std::map<std::string, std::string> hashes = stated_hashes(path);
    const std::string key = set.attribute(sample_key_attribute);
    for (const std::string& source : sources) {
        const std::string source_path = (fs::path(path).parent_path() / source).string();
        const auto hash = hashes.find(fs::path(source).filename().string());
        if (hash == hashes.end() || hash->second != sha256_path(source_path)) {
            defects.add("changed", fmt::format("{} is not the file that was merged", source_path));
        }
        try {
            const DeformationSet shard = open_deformations(source_path, set.num_volume_vertices);
            if (key.empty() || shard.attribute(sample_key_attribute) != key) {
                defects.add("key",
                            fmt::format("{} was made by another version of the method, from other inputs or with "
                                        "other options than the dataset states",
                                        source_path));
            }
        } catch (const InputError& error) {
            defects.add("unreadable", fmt::format("one of its shards cannot be read ({})", error.what()));
        }
    }
}

}  // namespace

std::vector<std::string> check_dataset(const std::string& dataset, const Splits& splits,
                                       const std::vector<std::string>& statistics)
{
    DeformationSet set;
    try {
        set = open_deformations(dataset);
    } catch (const InputError& error) {
        return {error.what()};
    }
    Defects defects(dataset);
    check_pairs(set, splits, defects);
    check_statistics(set, statistics, defects);
    check_sources(dataset, set, defects);
    check_vertices(set, defects);
    return defects.sentences();
}

std::string compare_with_stored(const SampleKey& key, const Points& vertices, const std::string& dataset)
{
    if (!fs::exists(dataset)) return "";
    const DeformationSet set = open_deformations(dataset);
    int place = 0;
    while (place < set.size() && (set.pair_splits[place] != key.split || !(set.pairs[place] == key.pair))) ++place;
    if (place == set.size()) return "";
    require_input(set.num_volume_vertices == vertices.rows(), "{}: samples have {} vertices, the template {}", dataset,
                  set.num_volume_vertices, vertices.rows());
    const RowMatrixF now = vertices.cast<float>();
    const std::vector<float> stored = set.coordinates(place);
    if (std::equal(stored.begin(), stored.end(), now.data())) {
        return fmt::format("{}: holds the same vertices, bit for bit\n", dataset);
    }
    double largest = 0;
    for (std::size_t k = 0; k < stored.size(); ++k) {
        largest = std::max(largest, std::abs(double(stored[k]) - double(now.data()[k])));
    }
    return fmt::format("{}: holds other vertices, up to {:.3g} m away\n", dataset, largest);
}

}  // namespace ndg
