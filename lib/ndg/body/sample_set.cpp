// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/sample_set.h"

#include "ndg/core/error.h"
#include "ndg/io/h5.h"

#include <algorithm>
#include <limits>
#include <set>

namespace ndg {

namespace {

constexpr int format_version = 1;
constexpr int max_index = std::numeric_limits<int>::max();

using PointsF = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;

RowMatrixI to_matrix(const std::vector<SamplePair>& pairs)
{
    RowMatrixI matrix(static_cast<Eigen::Index>(pairs.size()), 2);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        matrix.row(static_cast<Eigen::Index>(i)) << pairs[i].body_idx, pairs[i].pose_idx;
    }
    return matrix;
}

std::vector<SamplePair> to_pairs(const RowMatrixI& matrix)
{
    std::vector<SamplePair> pairs;
    for (Eigen::Index i = 0; i < matrix.rows(); ++i) pairs.push_back({matrix(i, 0), matrix(i, 1)});
    return pairs;
}

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
        std::set<std::pair<int, int>> seen;
        for (const SamplePair& pair : entries(splits.pairs, split)) {
            require_input(bodies.count(pair.body_idx) == 1 && poses.count(pair.pose_idx) == 1,
                          "{}: /splits/{}/pairs has body {} in pose {}, which are not both of that split", path, split,
                          pair.body_idx, pair.pose_idx);
            require_input(seen.emplace(pair.body_idx, pair.pose_idx).second,
                          "{}: /splits/{}/pairs has body {} in pose {} twice", path, split, pair.body_idx,
                          pair.pose_idx);
        }
    }
}

void check_split_names(const std::string& path, const std::vector<std::string>& splits)
{
    for (std::size_t i = 0; i < splits.size(); ++i) {
        require_input(std::find(split_names.begin(), split_names.end(), splits[i]) != split_names.end(),
                      "{}: /deformations/splits[{}] is \"{}\", not the name of a split", path, i, splits[i]);
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
        writer.write(group + "/pairs", to_matrix(entries(splits.pairs, split)), "body and pose of each sample");
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
        splits.pairs[split] = to_pairs(reader.read_int_matrix(group + "/pairs", -1, 2, 0, max_index));
    }
    check_splits(path, splits);
    return splits;
}

Points DeformationSet::points(int sample_idx) const
{
    require(sample_idx >= 0 && sample_idx < static_cast<int>(vertices.size()), "Sample {} was asked of {}", sample_idx,
            vertices.size());
    const std::vector<float>& stored = vertices[static_cast<std::size_t>(sample_idx)];
    return Eigen::Map<const PointsF>(stored.data(), num_volume_vertices, 3).cast<double>();
}

void DeformationSet::add(const SamplePair& pair, const std::string& split, const Points& sample_vertices)
{
    const int rows = static_cast<int>(sample_vertices.rows());
    if (pairs.empty() && num_volume_vertices == 0) num_volume_vertices = rows;
    require(rows == num_volume_vertices, "A sample of {} vertices was added to samples of {}", rows,
            num_volume_vertices);
    pairs.push_back(pair);
    pair_splits.push_back(split);
    std::vector<float>& stored = vertices.emplace_back(static_cast<std::size_t>(sample_vertices.size()));
    Eigen::Map<PointsF>(stored.data(), rows, 3) = sample_vertices.cast<float>();
}

void write_deformations(const std::string& path, const DeformationSet& set, const Provenance& provenance)
{
    const std::size_t count = set.pairs.size();
    const auto num_vertices = static_cast<std::size_t>(set.num_volume_vertices);
    require(set.pair_splits.size() == count && set.vertices.size() == count,
            "{} samples were given {} split names and {} deformed volumes", count, set.pair_splits.size(),
            set.vertices.size());
    check_split_names(path, set.pair_splits);

    H5Writer writer(path, "ndg-deformations", format_version, provenance);
    writer.attribute("method", set.method);
    writer.write("/deformations/pairs", to_matrix(set.pairs), "body and pose of each sample");
    writer.write("/deformations/splits", set.pair_splits, "split of each sample");
    writer.create("/deformations/vertices", {count, num_vertices, 3},
                  "deformed bone wrap, muscle wrap and volumetric skin of each sample, m");
    for (std::size_t i = 0; i < count; ++i) {
        require(set.vertices[i].size() == 3 * num_vertices, "Sample {} has {} coordinates instead of {}", i,
                set.vertices[i].size(), 3 * num_vertices);
        writer.write_slice("/deformations/vertices", i, set.vertices[i].data());
    }
    for (const auto& [name, values] : set.statistics) {
        require(values.size() == count, "Statistic {} has {} values for {} samples", name, values.size(), count);
        writer.write("/statistics/" + name, values, name + " of each sample");
    }
    writer.commit();
}

DeformationSet read_deformations(const std::string& path, int num_volume_vertices)
{
    const H5Reader reader(path, "ndg-deformations", format_version);
    DeformationSet set;
    set.method = reader.attribute("method");
    set.pairs = to_pairs(reader.read_int_matrix("/deformations/pairs", -1, 2, 0, max_index));
    const std::size_t count = set.pairs.size();
    set.pair_splits = reader.read_strings("/deformations/splits", static_cast<std::int64_t>(count));
    check_split_names(path, set.pair_splits);

    const std::vector<std::size_t> shape = reader.shape("/deformations/vertices");
    require_input(shape.size() == 3 && shape[0] == count && shape[2] == 3,
                  "{}: /deformations/vertices has shape {} instead of {} samples x vertices x 3", path,
                  fmt::join(shape, " x "), count);
    set.num_volume_vertices = static_cast<int>(shape[1]);
    require_input(num_volume_vertices < 0 || set.num_volume_vertices == num_volume_vertices,
                  "{}: /deformations/vertices has {} vertices a sample, but the template's volume has {}", path,
                  set.num_volume_vertices, num_volume_vertices);
    for (std::size_t i = 0; i < count; ++i) set.vertices.push_back(reader.read_slice("/deformations/vertices", i));

    const std::string group = "/statistics/";
    for (const H5Listing::Dataset& dataset : list_h5(path).datasets) {
        if (dataset.path.rfind(group, 0) != 0) continue;
        set.statistics[dataset.path.substr(group.size())] =
            reader.read_doubles(dataset.path, static_cast<std::int64_t>(count));
    }
    return set;
}

}  // namespace ndg
