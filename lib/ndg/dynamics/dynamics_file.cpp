// SPDX-License-Identifier: Apache-2.0
#include "ndg/dynamics/dynamics_file.h"

#include "ndg/core/error.h"
#include "ndg/dataset/shards.h"
#include "ndg/dynamics/motion_simulation.h"
#include "ndg/io/h5.h"
#include "ndg/io/h5_virtual.h"

#include <algorithm>
#include <filesystem>
#include <numeric>

namespace ndg {

namespace {

const std::string format = "ndg-dynamics", vertices_name = "/frames/vertices";
constexpr int version = 1;

}  // namespace

std::pair<int, int> DynamicsSet::frames_of(int sequence) const
{
    const auto s = static_cast<std::size_t>(sequence);
    return {frame_begin[s], s + 1 < frame_begin.size() ? frame_begin[s + 1] : num_frames()};
}

struct DynamicsWriter::State {
    H5Writer file;
};

namespace {

/// All but the vertices.
void write_lists(H5Writer& file, const DynamicsSet& set)
{
    file.attribute("model", set.model);
    file.attribute("simulation_key", set.key);
    file.attribute("convergence_criterion", set.convergence_criterion);
    file.attribute("time_step", set.time_step_seconds);
    file.attribute("frame_rate", set.frame_rate_hertz);
    file.write("/mesh/rest_vertices", set.rest, "vertices at rest, the held ones first", Storage::float64);
    file.write("/mesh/held_count", std::vector<int>{set.num_held}, "vertices that the pose holds");
    file.write("/mesh/skin_triangles", set.skin_triangles, "the skin, among the vertices");
    file.write("/sequences/names", set.sequence_names, "motions");
    file.write("/sequences/frame_begin", set.frame_begin, "first frame of each");
    file.write("/frames/times", set.times, "s from the start of the motion");
    for (const auto& [name, values] : set.statistics) {
        file.write("/statistics/" + name, values, "of the steps up to each frame");
    }
    if (!set.failed_sequences.empty()) {
        file.write("/failures/sequences", set.failed_sequences, "motions without result");
        file.write("/failures/reasons", set.failure_reasons, "why");
    }
}

std::vector<std::size_t> vertices_shape(const DynamicsSet& set)
{
    return {set.times.size(), static_cast<std::size_t>(set.rest.rows()), 3};
}

const std::string vertices_text = "vertices in the world, frame by frame";

}  // namespace

DynamicsWriter::DynamicsWriter(const std::string& path, const DynamicsSet& set, const Provenance& provenance)
    : state_(new State{{path, format, version, provenance}})
{
    write_lists(state_->file, set);
    state_->file.create(vertices_name, vertices_shape(set), vertices_text);
}

DynamicsSet join_dynamics(const std::string& path, int count, const Provenance& provenance)
{
    DynamicsSet joined;
    std::vector<VirtualSource> sources;
    for (int i = 0; i < count; ++i) {
        const std::filesystem::path shard = shard_path(path, {i, count});
        const DynamicsReader reader(shard.string());
        const DynamicsSet& set = reader.set();
        if (i == 0) {
            joined = set;
        } else {
            require_input(set.key == joined.key && set.rest == joined.rest,
                          "{}: was made from other inputs or with other options than the first shard", shard.string());
            for (const int begin : set.frame_begin) joined.frame_begin.push_back(joined.num_frames() + begin);
            const auto append = [](auto& list, const auto& more) { list.insert(list.end(), more.begin(), more.end()); };
            append(joined.sequence_names, set.sequence_names);
            append(joined.failed_sequences, set.failed_sequences);
            append(joined.failure_reasons, set.failure_reasons);
            for (const auto& [name, values] : set.statistics) append(joined.statistics[name], values);
            append(joined.times, set.times);
        }
        VirtualSource source;
        source.path = std::filesystem::relative(shard, std::filesystem::path(path).parent_path()).string();
        source.num_slices = set.times.size();
        source.slices.resize(set.times.size());
        std::iota(source.slices.begin(), source.slices.end(), std::size_t(0));
        for (const std::size_t slice : source.slices) {
            source.places.push_back(joined.times.size() - set.times.size() + slice);
        }
        sources.push_back(std::move(source));
    }
    H5Writer file(path, format, version, provenance);
    write_lists(file, joined);
    file.link(vertices_name, vertices_shape(joined), sources, vertices_text);
    file.commit();
    return joined;
}

DynamicsWriter::~DynamicsWriter() = default;

void DynamicsWriter::write(int frame, const std::vector<float>& vertices)
{
    state_->file.write_slice(vertices_name, static_cast<std::size_t>(frame), vertices.data());
}

void DynamicsWriter::commit()
{
    state_->file.commit();
}

struct DynamicsReader::State {
    H5Reader file;
    DynamicsSet set;
};

DynamicsReader::DynamicsReader(const std::string& path) : state_(new State{{path, format, version}, {}})
{
    const H5Reader& file = state_->file;
    DynamicsSet& set = state_->set;
    set.model = file.attribute("model");
    set.key = file.attribute("simulation_key");
    set.convergence_criterion = file.attribute("convergence_criterion");
    set.time_step_seconds = file.attribute_double("time_step");
    set.frame_rate_hertz = file.attribute_double("frame_rate");
    set.rest = file.read_matrix("/mesh/rest_vertices", -1, 3);
    set.num_held = file.read_ints("/mesh/held_count", 1, 0, set.num_vertices())[0];
    set.skin_triangles = file.read_int_matrix("/mesh/skin_triangles", -1, 3, 0, set.num_vertices() - 1);
    set.sequence_names = file.read_strings("/sequences/names");
    set.times = file.read_doubles("/frames/times");
    set.frame_begin = file.read_ints("/sequences/frame_begin", static_cast<std::int64_t>(set.sequence_names.size()), 0,
                                     set.num_frames());
    require_input(std::is_sorted(set.frame_begin.begin(), set.frame_begin.end()),
                  "{}: /sequences/frame_begin does not ascend", path);
    const std::vector<std::size_t> expected{set.times.size(), static_cast<std::size_t>(set.num_vertices()), 3};
    require_input(file.shape(vertices_name) == expected, "{}: {} does not hold {} frames of {} vertices", path,
                  vertices_name, set.num_frames(), set.num_vertices());
    for (const std::string& name : dynamics_statistics()) {
        set.statistics[name] = file.read_doubles("/statistics/" + name, set.num_frames());
    }
    if (file.has("/failures/sequences")) {
        set.failed_sequences = file.read_strings("/failures/sequences");
        set.failure_reasons =
            file.read_strings("/failures/reasons", static_cast<std::int64_t>(set.failed_sequences.size()));
    }
}

DynamicsReader::~DynamicsReader() = default;

const DynamicsSet& DynamicsReader::set() const
{
    return state_->set;
}

Points DynamicsReader::frame(int frame) const
{
    require_input(frame >= 0 && frame < set().num_frames(), "{}: frame {} of {}", state_->file.path(), frame,
                  set().num_frames());
    const std::vector<float> values = state_->file.read_slice(vertices_name, static_cast<std::size_t>(frame));
    return Eigen::Map<const RowMatrixF>(values.data(), set().rest.rows(), 3).cast<double>();
}

}  // namespace ndg
