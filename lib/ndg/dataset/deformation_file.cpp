// SPDX-License-Identifier: Apache-2.0
#include "ndg/dataset/deformation_file.h"

#include "ndg/core/error.h"
#include "ndg/io/h5_virtual.h"

#include <sys/resource.h>

#include <filesystem>
#include <set>

namespace ndg {

namespace {

const SamplePayload payload = {"ndg-deformations",
                               1,
                               "/deformations",
                               "/deformations/vertices",
                               "vertices",
                               3,
                               "deformed bone wrap, muscle wrap and volumetric skin of each sample, m"};
const std::string stop_reasons_name = "/deformations/stop_reasons", statistics_group = "/statistics/";

void put_failures(H5Writer& writer, const std::string& path, const std::vector<FailedSample>& failures)
{
    if (failures.empty()) return;
    std::vector<SamplePair> pairs;
    std::vector<std::string> splits, reasons;
    for (const FailedSample& failure : failures) {
        pairs.push_back(failure.pair);
        splits.push_back(failure.split);
        reasons.push_back(failure.reason);
    }
    check_split_names(path, "/failures/splits", splits);
    write_pairs(writer, "/failures", pairs, "body and pose of samples without deformation");
    writer.write("/failures/splits", splits, "split of each");
    writer.write("/failures/reasons", reasons, "why there is no deformation");
}

std::vector<FailedSample> get_failures(const H5Reader& reader)
{
    std::vector<FailedSample> failures;
    if (!reader.has("/failures/pairs")) return failures;
    const std::vector<SamplePair> pairs = read_pairs(reader, "/failures");
    const std::vector<std::string> splits = reader.read_strings("/failures/splits", pairs.size());
    const std::vector<std::string> reasons = reader.read_strings("/failures/reasons", pairs.size());
    check_split_names(reader.path(), "/failures/splits", splits);
    for (std::size_t i = 0; i < pairs.size(); ++i) failures.push_back({pairs[i], splits[i], reasons[i]});
    return failures;
}

/// All but index and vertices.
void put_figures(H5Writer& writer, const std::string& path, const DeformationSet& set)
{
    const std::size_t count = set.pairs.size();
    for (const auto& [name, value] : set.attributes) writer.attribute(name, value);
    if (!set.stop_reasons.empty()) {
        require(set.stop_reasons.size() == count, "{} samples were given {} stop reasons", count,
                set.stop_reasons.size());
        writer.write(stop_reasons_name, set.stop_reasons, "why the solver stopped");
    }
    for (const auto& [name, values] : set.statistics) {
        require(values.size() == count, "Statistic {} has {} values for {} samples", name, values.size(), count);
        writer.write(statistics_group + name, values, name + " of each sample");
    }
    put_failures(writer, path, set.failures);
}

void get_figures(const H5Reader& reader, DeformationSet& set)
{
    if (reader.has(stop_reasons_name)) set.stop_reasons = reader.read_strings(stop_reasons_name, set.size());
    set.failures = get_failures(reader);
    const H5Listing listing = list_h5(reader.path());
    static const std::set<std::string> common = {"format", "format_version", "units",    "up_axis", "created_by",
                                                 "config", "inputs",         "licences", "method",  "bone_wrap"};
    for (const auto& [name, value] : listing.attributes) {
        if (common.count(name) == 0) set.attributes[name] = value;
    }
    for (const H5Listing::Dataset& dataset : listing.datasets) {
        if (dataset.path.rfind(statistics_group, 0) != 0) continue;
        set.statistics[dataset.path.substr(statistics_group.size())] = reader.read_doubles(dataset.path, set.size());
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

std::string DeformationSet::attribute(const std::string& name) const
{
    const auto found = attributes.find(name);
    return found == attributes.end() ? "" : found->second;
}

std::vector<float> DeformationSet::coordinates(int sample_idx) const
{
    require(sample_idx >= 0 && sample_idx < size(), "Sample {} was asked of {}", sample_idx, size());
    if (file) return file->read(sample_idx);
    require(vertices.size() == pairs.size(), "{} samples have {} deformed volumes", pairs.size(), vertices.size());
    return vertices[sample_idx];
}

Points DeformationSet::points(int sample_idx) const
{
    const std::vector<float> stored = coordinates(sample_idx);
    require_input(pairs[sample_idx].num_frames == 1, "sample {} ({}) is a sequence, where a single pose is needed",
                  sample_idx, describe(pairs[sample_idx]));
    return Eigen::Map<const RowMatrixF>(stored.data(), num_volume_vertices, 3).cast<double>();
}

void DeformationSet::add(const SamplePair& pair, const std::string& split, const Points& sample_vertices)
{
    const int rows = static_cast<int>(sample_vertices.rows());
    if (pairs.empty() && num_volume_vertices == 0) num_volume_vertices = rows;
    require(rows == num_volume_vertices, "A sample of {} vertices was added to samples of {}", rows,
            num_volume_vertices);
    pairs.push_back(pair);
    pair_splits.push_back(split);
    std::vector<float>& stored = vertices.emplace_back(sample_vertices.size());
    Eigen::Map<RowMatrixF>(stored.data(), rows, 3) = sample_vertices.cast<float>();
}

DeformationWriter::DeformationWriter(const std::string& path, const DeformationSet& head, const Provenance& provenance)
    : SampleWriter(path, payload, head, head.num_volume_vertices, provenance)
{
    put_figures(file_, path, head);
}

void write_deformations(const std::string& path, const DeformationSet& set, const Provenance& provenance)
{
    DeformationWriter writer(path, set, provenance);
    for (int i = 0; i < set.size(); ++i) writer.write(i, set.coordinates(i));
    writer.commit();
}

void link_deformations(const std::string& path, const DeformationSet& head, const Provenance& provenance,
                       const std::vector<VirtualSource>& sources)
{
    H5Writer writer(path, payload.format, payload.version, provenance);
    write_sample_index(writer, path, payload.group, head);
    put_figures(writer, path, head);
    writer.link(payload.dataset, {head.num_slices(), static_cast<std::size_t>(head.num_volume_vertices), 3}, sources,
                payload.description);
    writer.commit();
}

std::vector<std::string> deformation_sources(const std::string& path)
{
    return virtual_sources(path, payload.dataset);
}

DeformationSet open_deformations(const std::string& path, int num_volume_vertices)
{
    DeformationSet set;
    set.file = std::make_shared<const SampleReader>(path, payload, num_volume_vertices);
    static_cast<SampleIndex&>(set) = set.file->index();
    set.num_volume_vertices = set.file->num_rows();
    get_figures(set.file->file(), set);
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    const std::vector<std::string> sources = deformation_sources(path);
    allow_open_files(path, sources.size());
    for (const std::string& source : sources) {
        require_input(std::filesystem::exists(folder / source), "{}: its samples lie in {}, which does not exist", path,
                      (folder / source).string());
    }
    return set;
}

}  // namespace ndg
