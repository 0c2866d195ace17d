// SPDX-License-Identifier: Apache-2.0
#include "ndg/dataset/sample_index.h"

#include "ndg/core/error.h"
#include "ndg/io/h5.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <tuple>

namespace ndg {

namespace {

constexpr int max_index = std::numeric_limits<int>::max();

auto as_tuple(const SamplePair& pair)
{
    return std::make_tuple(pair.body_idx, pair.pose_idx, pair.num_frames);
}

std::size_t count_slices(const std::vector<SamplePair>& pairs, int end)
{
    return std::accumulate(pairs.begin(), pairs.begin() + end, std::size_t{0},
                           [](std::size_t sum, const SamplePair& pair) { return sum + pair.num_frames; });
}

}  // namespace

bool operator==(const SamplePair& a, const SamplePair& b)
{
    return as_tuple(a) == as_tuple(b);
}

bool operator<(const SamplePair& a, const SamplePair& b)
{
    return as_tuple(a) < as_tuple(b);
}

std::string describe(const SamplePair& pair)
{
    if (pair.num_frames == 1) return fmt::format("body {} in pose {}", pair.body_idx, pair.pose_idx);
    return fmt::format("body {} in poses {} to {}", pair.body_idx, pair.pose_idx, pair.pose_idx + pair.num_frames - 1);
}

void require_pair(const SamplePair& pair, std::size_t num_bodies, std::size_t num_poses)
{
    require_input(pair.num_frames == 1, "a sample ({}) is a sequence, where single poses are needed", describe(pair));
    require_input(pair.body_idx >= 0 && static_cast<std::size_t>(pair.body_idx) < num_bodies,
                  "a sample names body {}, but there are {} bodies", pair.body_idx, num_bodies);
    require_input(pair.pose_idx >= 0 && static_cast<std::size_t>(pair.pose_idx) < num_poses,
                  "a sample names pose {}, but there are {} poses", pair.pose_idx, num_poses);
}

bool operator<(const SampleKey& a, const SampleKey& b)
{
    return std::tie(a.split, a.pair) < std::tie(b.split, b.pair);
}

std::string describe(const SampleKey& key)
{
    return fmt::format("{} of split {}", describe(key.pair), key.split);
}

std::size_t SampleIndex::num_slices() const
{
    return count_slices(pairs, size());
}

std::size_t SampleIndex::first_slice(int sample_idx) const
{
    require(sample_idx >= 0 && sample_idx < size(), "Sample {} was asked of {}", sample_idx, size());
    return count_slices(pairs, sample_idx);
}

void check_split_names(const std::string& path, const std::string& name, const std::vector<std::string>& splits)
{
    for (std::size_t i = 0; i < splits.size(); ++i) {
        require_input(std::find(split_names.begin(), split_names.end(), splits[i]) != split_names.end(),
                      "{}: {}[{}] is \"{}\", not the name of a split", path, name, i, splits[i]);
    }
}

void write_pairs(H5Writer& writer, const std::string& group, const std::vector<SamplePair>& pairs,
                 const std::string& description)
{
    RowMatrixI matrix(pairs.size(), 2);
    std::vector<int> frames;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        matrix.row(i) << pairs[i].body_idx, pairs[i].pose_idx;
        frames.push_back(pairs[i].num_frames);
    }
    writer.write(group + "/pairs", matrix, description);
    if (std::any_of(frames.begin(), frames.end(), [](int count) { return count != 1; })) {
        writer.write(group + "/frames", frames, "number of successive poses of each sample");
    }
}

std::vector<SamplePair> read_pairs(const H5Reader& reader, const std::string& group)
{
    const RowMatrixI matrix = reader.read_int_matrix(group + "/pairs", -1, 2, 0, max_index);
    std::vector<int> frames(matrix.rows(), 1);
    if (reader.has(group + "/frames")) frames = reader.read_ints(group + "/frames", matrix.rows(), 1, max_index);
    std::vector<SamplePair> pairs;
    for (Eigen::Index i = 0; i < matrix.rows(); ++i) pairs.push_back({matrix(i, 0), matrix(i, 1), frames[i]});
    return pairs;
}

void write_sample_index(H5Writer& writer, const std::string& path, const std::string& group, const SampleIndex& index)
{
    require(index.pair_splits.size() == index.pairs.size(), "{} samples were given {} split names", index.pairs.size(),
            index.pair_splits.size());
    check_split_names(path, group + "/splits", index.pair_splits);
    writer.attribute("method", index.method);
    write_posing(writer, index.posing);
    write_pairs(writer, group, index.pairs);
    writer.write(group + "/splits", index.pair_splits, "split of each sample");
}

SampleIndex read_sample_index(const H5Reader& reader, const std::string& group)
{
    SampleIndex index;
    index.method = reader.attribute("method");
    index.posing = read_posing(reader);
    index.pairs = read_pairs(reader, group);
    index.pair_splits = reader.read_strings(group + "/splits", index.size());
    check_split_names(reader.path(), group + "/splits", index.pair_splits);
    return index;
}

}  // namespace ndg
