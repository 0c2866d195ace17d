// SPDX-License-Identifier: Apache-2.0
#include "ndg/capture/import_capture.h"

#include "ndg/core/error.h"
#include "ndg/io/h5.h"
#include "ndg/io/h5_array.h"
#include "ndg/io/mesh.h"
#include "ndg/motion/resample_poses.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>

namespace ndg {

namespace {

namespace fs = std::filesystem;
using Say = std::function<void(const std::string&)>;

/// The digits that a file's name ends in before its extension; none for a name without.
std::optional<int> trailing_number(const std::string& stem)
{
    std::size_t begin = stem.size();
    while (begin > 0 && std::isdigit(static_cast<unsigned char>(stem[begin - 1])) != 0) --begin;
    int number = 0;
    const auto [end, error] = std::from_chars(stem.data() + begin, stem.data() + stem.size(), number);
    if (begin == stem.size() || error != std::errc()) return std::nullopt;
    return number;
}

void check_triangles(const std::string& path, const Triangles& found, const CaptureSurface& surface)
{
    require_input(found.rows() == surface.triangles.rows(), "{}: {} triangles, the body's skin has {}", path,
                  found.rows(), surface.triangles.rows());
    for (Eigen::Index t = 0; t < found.rows(); ++t) {
        require_input(found.row(t) == surface.triangles.row(t), "{}: triangle {} is {} {} {}, the body's is {} {} {}",
                      path, t, found(t, 0), found(t, 1), found(t, 2), surface.triangles(t, 0), surface.triangles(t, 1),
                      surface.triangles(t, 2));
    }
}

/// Leaves out a frame with a vertex that is no number, and says so.
void add_frame(CaptureSequence& sequence, int number, Points vertices, const std::string& where, const Say& say)
{
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
        if (vertices.row(v).allFinite()) continue;
        say(fmt::format("{}: frame {} is left out as missing: vertex {} is no number", where, number, v));
        return;
    }
    sequence.frame_numbers.push_back(number);
    sequence.vertices.push_back(std::move(vertices));
}

CaptureSequence from_folder(const std::string& path, const CaptureSurface& surface, const CaptureImportOptions& options,
                            const Say& say)
{
    std::map<int, std::string> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(path)) {
        const std::string file = entry.path().string(), extension = lower_extension(file);
        if (extension != ".obj" && extension != ".ply") continue;
        const std::optional<int> number = trailing_number(entry.path().stem().string());
        require_input(number.has_value(), "{}: the name does not end in the frame's number", file);
        const auto [at, added] = files.emplace(*number, file);
        require_input(added, "{} and {} are both frame {}", at->second, file, *number);
    }
    require_input(!files.empty(), "{}: there is no .obj or .ply file in it", path);
    CaptureSequence sequence;
    for (const auto& [number, file] : files) {
        MeshReading reading;
        reading.drop_invalid = true;
        MeshFile mesh = read_mesh(file, reading);
        if (mesh.num_dropped > 0) {
            say(fmt::format("{}: frame {} is left out as missing: {} vertices are no numbers", file, number,
                            mesh.num_dropped));
            continue;
        }
        require_input(mesh.vertices.rows() == surface.num_vertices, "{}: {} vertices, the body's skin has {}", file,
                      mesh.vertices.rows(), surface.num_vertices);
        check_triangles(file, mesh.triangles, surface);
        add_frame(sequence, number, options.metres_per_unit * mesh.vertices, file, say);
    }
    return sequence;
}

std::string shape_text(const NpyArray& array)
{
    return array.shape.empty() ? "a single number" : fmt::format("{}", fmt::join(array.shape, " x "));
}

CaptureSequence from_array(const NpyArray& array, const std::string& where, const CaptureSurface& surface,
                           const CaptureImportOptions& options, const Say& say)
{
    const Eigen::Index n = surface.num_vertices;
    const bool frames_first = array.shape.size() == 3 && array.shape[1] == n && array.shape[2] == 3;
    const bool frames_last = array.shape.size() == 3 && array.shape[0] == n && array.shape[1] == 3;
    require_input(frames_first || frames_last, "{}: is {}, expected frames x {} x 3 or {} x 3 x frames", where,
                  shape_text(array), n, n);
    const auto frames = static_cast<Eigen::Index>(frames_first ? array.shape[0] : array.shape[2]);
    if (!frames_first) say(fmt::format("{}: {}, frames last: axes swapped", where, shape_text(array)));
    CaptureSequence sequence;
    for (Eigen::Index f = 0; f < frames; ++f) {
        Points vertices(n, 3);
        for (Eigen::Index v = 0; v < n; ++v) {
            for (Eigen::Index c = 0; c < 3; ++c) {
                const Eigen::Index at = frames_first ? (f * n + v) * 3 + c : (v * 3 + c) * frames + f;
                vertices(v, c) = options.metres_per_unit * array.values[static_cast<std::size_t>(at)];
            }
        }
        add_frame(sequence, static_cast<int>(f), std::move(vertices), where, say);
    }
    return sequence;
}

std::vector<CaptureSequence> from_npz(const std::string& path, const CaptureSurface& surface,
                                      const CaptureImportOptions& options, const Say& say)
{
    const NpzFile file(path);
    std::vector<CaptureSequence> sequences;
    for (const std::string& key : file.keys()) {
        const NpyArray array = file.read(key, false);
        if (array.shape.size() != 3) continue;
        sequences.push_back(from_array(array, fmt::format("{}: \"{}\"", path, key), surface, options, say));
        sequences.back().name = key;
    }
    require_input(!sequences.empty(), "{}: there is no array of three axes in it", path);
    if (sequences.size() == 1) sequences[0].name = fs::path(path).stem().string();
    return sequences;
}

std::vector<CaptureSequence> from_h5(const std::string& path, const CaptureSurface& surface,
                                     const CaptureImportOptions& options, const Say& say)
{
    std::vector<CaptureSequence> sequences;
    for (const H5Listing::Dataset& dataset : list_h5(path).datasets) {
        if (dataset.path == "/faces") {
            const NpyArray faces = read_h5_array(path, dataset.path);
            require_input(faces.shape.size() == 2 && faces.shape[1] == 3, "{}: /faces is {}, expected faces x 3", path,
                          shape_text(faces));
            Triangles triangles(faces.shape[0], 3);
            for (Eigen::Index i = 0; i < triangles.size(); ++i) {
                const double value = faces.values[static_cast<std::size_t>(i)];
                require_input(value >= 0 && value < static_cast<double>(surface.num_vertices),
                              "{}: /faces has {} at face {}, expected a vertex of 0 to {}", path, value, i / 3,
                              surface.num_vertices - 1);
                triangles.data()[i] = static_cast<int>(value);
            }
            check_triangles(path + ": /faces", triangles, surface);
        }
        if (dataset.shape.size() != 3) continue;
        sequences.push_back(
            from_array(read_h5_array(path, dataset.path), path + ": " + dataset.path, surface, options, say));
        std::string name = dataset.path.substr(1);
        if (name.rfind("sids/", 0) == 0) name = name.substr(5);
        std::replace(name.begin(), name.end(), '/', '_');
        sequences.back().name = name;
    }
    require_input(!sequences.empty(), "{}: there is no dataset of three axes in it", path);
    return sequences;
}

void finish(CaptureSequence& sequence, const std::string& path, const CaptureImportOptions& options, const Say& say)
{
    sequence.frame_rate_hertz = options.frame_rate_hertz;
    require_input(sequence.num_frames() >= 2, "{}: sequence \"{}\" has {} frames, a motion has two at least", path,
                  sequence.name, sequence.num_frames());
    const int recorded = sequence.num_recorded(), missing = recorded - sequence.num_frames();
    std::string gap;
    for (std::size_t f = 1; f < sequence.frame_numbers.size() && gap.empty(); ++f) {
        if (sequence.frame_numbers[f] > sequence.frame_numbers[f - 1] + 1) {
            gap = fmt::format(", {} of them missing, first {}", missing, sequence.frame_numbers[f - 1] + 1);
        }
    }
    require_input(missing <= options.most_missing * recorded,
                  "{}: sequence \"{}\" lacks {} of {} frames, more than --most-missing {} allows", path, sequence.name,
                  missing, recorded, options.most_missing);
    say(fmt::format("{}: {} frames at {:g} Hz, {:.2f} s{}", sequence.name, recorded, sequence.frame_rate_hertz,
                    sequence.seconds(), gap));
}

}  // namespace

void describe(OptionList& list, CaptureImportOptions& options)
{
    list.add("frame-rate", options.frame_rate_hertz, "frames a second of the recording", 1, 1e4);
    list.add("scale", options.metres_per_unit, "metres a unit of the files", 1e-6, 1e6);
    list.add("most-missing", options.most_missing, "share of a sequence's frames that may be missing", 0, 0.5);
}

std::vector<CaptureSequence> import_sequences(const std::string& path, const CaptureSurface& surface,
                                              const CaptureImportOptions& options, const Say& say)
{
    check_options(options);
    std::vector<CaptureSequence> sequences;
    const std::string extension = lower_extension(path);
    if (fs::is_directory(path)) {
        sequences = {from_folder(path, surface, options, say)};
        sequences[0].name = fs::canonical(path).filename().string();
    } else if (extension == ".npy") {
        sequences = {from_array(read_npy(path, false), path, surface, options, say)};
        sequences[0].name = fs::path(path).stem().string();
    } else if (extension == ".npz") {
        sequences = from_npz(path, surface, options, say);
    } else {
        require_input(extension == ".h5" || extension == ".hdf5",
                      "{}: expected a folder of .obj or .ply files, .npy, .npz, .h5 or .hdf5", path);
        sequences = from_h5(path, surface, options, say);
    }
    for (CaptureSequence& sequence : sequences) finish(sequence, path, options, say);
    return sequences;
}

void attach_poses(CaptureSequence& sequence, const PoseSet& poses, const std::string& path)
{
    PoseSet clip;
    for (int p = 0; p < poses.size(); ++p) {
        const auto k = static_cast<std::size_t>(p), c = static_cast<std::size_t>(poses.clip_idx[k]);
        if (poses.clip_names[c] != sequence.name || poses.is_spliced(p)) continue;
        clip.clip_names = {poses.clip_names[c]};
        clip.clip_frame_rates = {poses.clip_frame_rates[c]};
        clip.poses.push_back(poses.poses[k]);
        clip.clip_idx.push_back(0);
        clip.frame_idx.push_back(poses.frame_idx[k]);
    }
    require_input(clip.size() > 1, "{}: there is no motion \"{}\" among its {} clips", path, sequence.name,
                  poses.clip_names.size());
    const double seconds = (clip.frame_idx.back() - clip.frame_idx.front()) / clip.clip_frame_rates[0];
    require_input(
        std::abs(seconds - sequence.seconds()) <= 2 / sequence.frame_rate_hertz,
        "{}: sequence \"{}\" lasts {:.3f} s at {:g} Hz, its poses last {:.3f} s at {:g} Hz: one of both frame "
        "rates is another",
        path, sequence.name, sequence.seconds(), sequence.frame_rate_hertz, seconds, clip.clip_frame_rates[0]);
    const PoseSet resampled = resample_poses(clip, sequence.frame_rate_hertz);
    sequence.poses.clear();
    for (const int number : sequence.frame_numbers) {
        const int at = std::min(number - sequence.frame_numbers[0], resampled.size() - 1);
        sequence.poses.push_back(resampled.poses[static_cast<std::size_t>(at)]);
    }
}

}  // namespace ndg
