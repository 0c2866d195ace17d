// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/sample_set.h"
#include "ndg/core/error.h"
#include "ndg/io/h5.h"
#include "ndg/io/h5_virtual.h"

#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <mutex>
#include <set>

namespace ndg {

namespace {

constexpr int format_version = 1;
constexpr int max_index = std::numeric_limits<int>::max();
const std::string format = "ndg-deformations", vertices_name = "/deformations/vertices",
                  vertices_description = "deformed bone wrap, muscle wrap and volumetric skin of each sample, m";

using PointsF = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;

template <typename Samples, typename Pair>
RowMatrixI pair_matrix(const Samples& samples, const Pair& pair_of)
{
    RowMatrixI matrix(static_cast<Eigen::Index>(samples.size()), 2);
    Eigen::Index row = 0;
    for (const auto& sample : samples) {
        const SamplePair& pair = pair_of(sample);
        matrix.row(row++) << pair.body_idx, pair.pose_idx;
    }
    return matrix;
}

void check_split_names(const std::string& path, const std::string& name, const std::vector<std::string>& splits)
{
    for (std::size_t i = 0; i < splits.size(); ++i) {
        require_input(std::find(split_names.begin(), split_names.end(), splits[i]) != split_names.end(),
                      "{}: {}[{}] is \"{}\", not the name of a split", path, name, i, splits[i]);
    }
}

void put_failures(H5Writer& writer, const std::string& path, const std::vector<FailedSample>& failures)
{
    if (failures.empty()) return;
    std::vector<std::string> splits, reasons;
    for (const FailedSample& failure : failures) {
        splits.push_back(failure.split);
        reasons.push_back(failure.reason);
    }
    check_split_names(path, "/failures/splits", splits);
    const auto pair_of = [](const FailedSample& failure) -> const SamplePair& { return failure.pair; };
    writer.write("/failures/pairs", pair_matrix(failures, pair_of), "body and pose of samples without deformation");
    writer.write("/failures/splits", splits, "split of each");
    writer.write("/failures/reasons", reasons, "why there is no deformation");
}

/// All but the vertices.
void put_lists(H5Writer& writer, const std::string& path, const DeformationSet& set)
{
    const std::size_t count = set.pairs.size();
    require(set.pair_splits.size() == count, "{} samples were given {} split names", count, set.pair_splits.size());
    check_split_names(path, "/deformations/splits", set.pair_splits);
    writer.attribute("method", set.method);
    for (const auto& [name, value] : set.attributes) writer.attribute(name, value);
    const auto pair_of = [](const SamplePair& pair) -> const SamplePair& { return pair; };
    writer.write("/deformations/pairs", pair_matrix(set.pairs, pair_of), "body and pose of each sample");
    writer.write("/deformations/splits", set.pair_splits, "split of each sample");
    if (!set.stop_reasons.empty()) {
        require(set.stop_reasons.size() == count, "{} samples were given {} stop reasons", count,
                set.stop_reasons.size());
        writer.write("/deformations/stop_reasons", set.stop_reasons, "why the solver stopped");
    }
    for (const auto& [name, values] : set.statistics) {
        require(values.size() == count, "Statistic {} has {} values for {} samples", name, values.size(), count);
        writer.write("/statistics/" + name, values, name + " of each sample");
    }
    put_failures(writer, path, set.failures);
}

std::vector<FailedSample> get_failures(const H5Reader& reader)
{
    std::vector<FailedSample> failures;
    if (!reader.has("/failures/pairs")) return failures;
    const RowMatrixI pairs = reader.read_int_matrix("/failures/pairs", -1, 2, 0, max_index);
    const std::vector<std::string> splits = reader.read_strings("/failures/splits", pairs.rows());
    const std::vector<std::string> reasons = reader.read_strings("/failures/reasons", pairs.rows());
    check_split_names(reader.path(), "/failures/splits", splits);
    for (Eigen::Index i = 0; i < pairs.rows(); ++i) {
        const auto place = static_cast<std::size_t>(i);
        failures.push_back({{pairs(i, 0), pairs(i, 1)}, splits[place], reasons[place]});
    }
    return failures;
}

void get_lists(const H5Reader& reader, DeformationSet& set)
{
    const std::string& path = reader.path();
    const RowMatrixI pairs = reader.read_int_matrix("/deformations/pairs", -1, 2, 0, max_index);
    for (Eigen::Index i = 0; i < pairs.rows(); ++i) set.pairs.push_back({pairs(i, 0), pairs(i, 1)});
    const auto count = static_cast<std::int64_t>(set.pairs.size());
    set.pair_splits = reader.read_strings("/deformations/splits", count);
    check_split_names(path, "/deformations/splits", set.pair_splits);
    if (reader.has("/deformations/stop_reasons")) {
        set.stop_reasons = reader.read_strings("/deformations/stop_reasons", count);
    }
    set.failures = get_failures(reader);

    const H5Listing listing = list_h5(path);
    static const std::set<std::string> common = {"format", "format_version", "units",    "up_axis", "created_by",
                                                 "config", "inputs",         "licences", "method"};
    for (const auto& [name, value] : listing.attributes) {
        if (common.count(name) == 0) set.attributes[name] = value;
    }
    const std::string group = "/statistics/";
    for (const H5Listing::Dataset& dataset : listing.datasets) {
        if (dataset.path.rfind(group, 0) != 0) continue;
        set.statistics[dataset.path.substr(group.size())] = reader.read_doubles(dataset.path, count);
    }
}

/// HDF5 keeps every file of a virtual dataset open once it was read; the usual limit is 1024.
void allow_open_files(const std::string& path, std::size_t count)
{
    constexpr rlim_t others = 128;
    rlimit limit{};
    if (::getrlimit(RLIMIT_NOFILE, &limit) != 0 || count + others <= limit.rlim_cur) return;
    require_input(count + others <= limit.rlim_max,
                  "{}: its samples lie in {} files, more than can be open at once (ulimit -n: {})", path, count,
                  limit.rlim_max);
    limit.rlim_cur = limit.rlim_max;
    ::setrlimit(RLIMIT_NOFILE, &limit);
}

}  // namespace

std::vector<float> DeformationSet::coordinates(int sample_idx) const
{
    require(sample_idx >= 0 && sample_idx < size(), "Sample {} was asked of {}", sample_idx, size());
    if (file) {
        static std::mutex mutex;  // of all sets: HDF5 is not thread-safe
        const std::lock_guard<std::mutex> lock(mutex);
        return file->read_slice(vertices_name, static_cast<std::size_t>(sample_idx));
    }
    require(vertices.size() == pairs.size(), "{} samples have {} deformed volumes", pairs.size(), vertices.size());
    return vertices[static_cast<std::size_t>(sample_idx)];
}

Points DeformationSet::points(int sample_idx) const
{
    const std::vector<float> stored = coordinates(sample_idx);
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
    write_deformations(path, set, provenance, [&](int sample_idx) { return set.coordinates(sample_idx); });
}

void write_deformations(const std::string& path, const DeformationSet& set, const Provenance& provenance,
                        const std::function<std::vector<float>(int)>& coordinates)
{
    const auto num_vertices = static_cast<std::size_t>(set.num_volume_vertices);
    H5Writer writer(path, format, format_version, provenance);
    put_lists(writer, path, set);
    writer.create(vertices_name, {set.pairs.size(), num_vertices, 3}, vertices_description);
    for (int i = 0; i < set.size(); ++i) {
        const std::vector<float> sample = coordinates(i);
        require(sample.size() == 3 * num_vertices, "Sample {} has {} coordinates instead of {}", i, sample.size(),
                3 * num_vertices);
        writer.write_slice(vertices_name, static_cast<std::size_t>(i), sample.data());
    }
    writer.commit();
}

void link_deformations(const std::string& path, const DeformationSet& set, const Provenance& provenance,
                       const std::vector<VirtualSource>& sources)
{
    H5Writer writer(path, format, format_version, provenance);
    put_lists(writer, path, set);
    writer.link(vertices_name, {set.pairs.size(), static_cast<std::size_t>(set.num_volume_vertices), 3}, sources,
                vertices_description);
    writer.commit();
}

DeformationSet open_deformations(const std::string& path, int num_volume_vertices)
{
    const auto reader = std::make_shared<const H5Reader>(path, format, format_version);
    DeformationSet set;
    set.method = reader->attribute("method");
    get_lists(*reader, set);
    const std::size_t count = set.pairs.size();
    const std::vector<std::size_t> shape = reader->shape(vertices_name);
    require_input(shape.size() == 3 && shape[0] == count && shape[2] == 3,
                  "{}: {} has shape {} instead of {} samples x vertices x 3", path, vertices_name,
                  fmt::join(shape, " x "), count);
    set.num_volume_vertices = static_cast<int>(shape[1]);
    require_input(num_volume_vertices < 0 || set.num_volume_vertices == num_volume_vertices,
                  "{}: {} has {} vertices a sample, but the template's volume has {}", path, vertices_name,
                  set.num_volume_vertices, num_volume_vertices);
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    const std::vector<std::string> sources = virtual_sources(path, vertices_name);
    allow_open_files(path, sources.size());
    for (const std::string& source : sources) {
        require_input(std::filesystem::exists(folder / source), "{}: its samples lie in {}, which does not exist", path,
                      (folder / source).string());
    }
    set.file = reader;
    return set;
}

DeformationSet read_deformations(const std::string& path, int num_volume_vertices)
{
    DeformationSet set = open_deformations(path, num_volume_vertices);
    for (int i = 0; i < set.size(); ++i) set.vertices.push_back(set.coordinates(i));
    set.file.reset();
    return set;
}

}  // namespace ndg
