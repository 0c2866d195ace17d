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

const std::string format = "ndg-dynamics", vertices_name = "/frames/vertices", rotations_name = "/frames/rotations",
                  roots_name = "/frames/root_translations";
constexpr int version = 2;

void write_poses_of(H5Writer& file, const std::vector<Pose>& poses)
{
    const std::size_t joints = poses[0].parent_from_joint.size();
    std::vector<float> rotations;
    rotations.reserve(poses.size() * joints * 9);
    RowMatrix roots(static_cast<Eigen::Index>(poses.size()), 3);
    for (std::size_t i = 0; i < poses.size(); ++i) {
        for (const Eigen::Matrix3d& rotation : poses[i].parent_from_joint) {
            for (int k = 0; k < 9; ++k) rotations.push_back(static_cast<float>(rotation(k / 3, k % 3)));
        }
        roots.row(static_cast<Eigen::Index>(i)) = poses[i].root_translation.transpose();
    }
    file.write(rotations_name, {poses.size(), joints, 9}, rotations.data(),
               "the pose of each frame: row-major rotation of each joint, from joint frame to parent frame");
    file.write(roots_name, roots, "world displacement of the root joint, m", Storage::float64);
}

std::vector<Pose> read_poses_of(const H5Reader& file, std::size_t frames)
{
    const std::vector<std::size_t> shape = file.shape(rotations_name);
    require_input(shape.size() == 3 && shape[0] == frames && shape[2] == 9,
                  "{}: {} does not hold the poses of {} frames", file.path(), rotations_name, frames);
    const RowMatrix roots = file.read_matrix(roots_name, static_cast<Eigen::Index>(frames), 3);
    std::vector<Pose> poses(frames);
    for (std::size_t i = 0; i < frames; ++i) {
        const std::vector<float> values = file.read_slice(rotations_name, i);
        for (std::size_t j = 0; j < shape[1]; ++j) {
            using Stored = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;
            poses[i].parent_from_joint.push_back(Eigen::Map<const Stored>(&values[9 * j]).cast<double>());
        }
        poses[i].root_translation = roots.row(static_cast<Eigen::Index>(i)).transpose();
    }
    return poses;
}

void write_others(H5Writer& file, const std::vector<DynamicSurface>& others)
{
    std::vector<std::string> names;
    std::vector<int> garment, begin;
    Eigen::Index count = 0;
    for (const DynamicSurface& surface : others) count += surface.triangles.rows();
    Triangles triangles(count, 3);
    count = 0;
    for (const DynamicSurface& surface : others) {
        names.push_back(surface.name);
        garment.push_back(surface.garment ? 1 : 0);
        begin.push_back(static_cast<int>(count));
        triangles.middleRows(count, surface.triangles.rows()) = surface.triangles;
        count += surface.triangles.rows();
    }
    file.write("/others/names", names, "surfaces beside the skin");
    file.write("/others/garment", garment, "1: a garment, 0: an obstacle");
    file.write("/others/triangle_begin", begin, "first triangle of each");
    file.write("/others/triangles", triangles, "among the vertices");
}

std::vector<DynamicSurface> read_others(const H5Reader& file, int num_vertices)
{
    std::vector<DynamicSurface> others;
    if (!file.has("/others/names")) return others;
    const std::vector<std::string> names = file.read_strings("/others/names");
    const auto count = static_cast<std::int64_t>(names.size());
    const Triangles triangles = file.read_int_matrix("/others/triangles", -1, 3, 0, num_vertices - 1);
    const std::vector<int> garment = file.read_ints("/others/garment", count, 0, 1);
    std::vector<int> begin = file.read_ints("/others/triangle_begin", count, 0, static_cast<int>(triangles.rows()));
    begin.push_back(static_cast<int>(triangles.rows()));
    require_input(std::is_sorted(begin.begin(), begin.end()), "{}: /others/triangle_begin does not ascend",
                  file.path());
    for (std::size_t i = 0; i < names.size(); ++i) {
        others.push_back({names[i], garment[i] != 0, triangles.middleRows(begin[i], begin[i + 1] - begin[i])});
    }
    return others;
}

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
    require(set.poses.size() == set.times.size() && !set.poses.empty(), "{} poses of {} frames", set.poses.size(),
            set.times.size());
    write_poses_of(file, set.poses);
    if (!set.others.empty()) write_others(file, set.others);
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
            append(joined.poses, set.poses);
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
    set.poses = read_poses_of(file, set.times.size());
    set.others = read_others(file, set.num_vertices());
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
DynamicsReader::DynamicsReader(DynamicsReader&&) noexcept = default;

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
