// SPDX-License-Identifier: Apache-2.0
#include "ndg/dataset/splits.h"

#include "ndg/core/error.h"
#include "ndg/io/h5.h"

#include <algorithm>
#include <limits>
#include <set>

namespace ndg {

namespace {

constexpr int format_version = 1;
constexpr int max_index = std::numeric_limits<int>::max();

template <typename Value>
const std::vector<Value>& entries(const std::map<std::string, std::vector<Value>>& by_split, const std::string& split)
{
    static const std::vector<Value> none;
    const auto found = by_split.find(split);
    return found == by_split.end() ? none : found->second;
}

/// No index twice, neither within a split nor in two.
void check_disjoint(const std::string& path, const std::map<std::string, std::vector<int>>& by_split,
                    const std::string& kind)
{
    std::map<int, std::string> split_of;
    for (const std::string& split : split_names) {
        for (const int index : entries(by_split, split)) {
            const auto [earlier, is_new] = split_of.emplace(index, split);
            require_input(is_new, "{}: /splits/{}/{} has {}, which stands in {} already", path, split, kind, index,
                          earlier->second);
        }
    }
}

void check_splits(const std::string& path, const Splits& splits)
{
    check_disjoint(path, splits.bodies, "bodies");
    check_disjoint(path, splits.poses, "poses");
    for (const std::string& split : split_names) {
        const std::vector<int>& split_bodies = entries(splits.bodies, split);
        const std::vector<int>& split_poses = entries(splits.poses, split);
        const std::set<int> bodies(split_bodies.begin(), split_bodies.end());
        const std::set<int> poses(split_poses.begin(), split_poses.end());
        std::set<SamplePair> seen;
        for (const SamplePair& pair : entries(splits.pairs, split)) {
            bool in_split = bodies.count(pair.body_idx) == 1;
            for (int f = 0; f < pair.num_frames; ++f) in_split = in_split && poses.count(pair.pose_idx + f) == 1;
            require_input(in_split, "{}: /splits/{}/pairs has {}, which are not all of that split", path, split,
                          describe(pair));
            require_input(seen.insert(pair).second, "{}: /splits/{}/pairs has {} twice", path, split, describe(pair));
        }
    }
}

}  // namespace

void write_splits(const std::string& path, const Splits& splits, const Provenance& provenance)
{
    check_splits(path, splits);
    H5Writer writer(path, "ndg-splits", format_version, provenance);
    for (const std::string& split : split_names) {
        const std::string group = "/splits/" + split;
        writer.write(group + "/bodies", entries(splits.bodies, split), "indices of the bodies of this split");
        writer.write(group + "/poses", entries(splits.poses, split), "indices of the poses of this split");
        write_pairs(writer, group, entries(splits.pairs, split));
    }
    writer.commit();
}

Splits read_splits(const std::string& path, int num_bodies, int num_poses)
{
    const H5Reader reader(path, "ndg-splits", format_version);
    const int last_body = num_bodies < 0 ? max_index : num_bodies - 1;
    const int last_pose = num_poses < 0 ? max_index : num_poses - 1;
    Splits splits;
    for (const std::string& split : split_names) {
        const std::string group = "/splits/" + split;
        splits.bodies[split] = reader.read_ints(group + "/bodies", -1, 0, last_body);
        splits.poses[split] = reader.read_ints(group + "/poses", -1, 0, last_pose);
        splits.pairs[split] = read_pairs(reader, group);
    }
    check_splits(path, splits);
    return splits;
}

}  // namespace ndg
