// SPDX-License-Identifier: Apache-2.0
#include "ndg/capture/capture.h"

#include "ndg/core/error.h"
#include "ndg/io/h5.h"

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

constexpr const char* format_name = "ndg-capture";
constexpr int format_version = 1;
constexpr double rotation_tolerance = 1e-4;
constexpr int most_frames = 1 << 24;

using StoredRotation = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;

void write_pose_arrays(H5Writer& writer, const Capture& capture)
{
    const std::size_t joints = capture.joint_names.size();
    std::vector<float> rotations;
    std::vector<Eigen::Vector3d> translations;
    for (const CaptureSequence& sequence : capture.sequences) {
        for (const Pose& pose : sequence.poses) {
            for (const Eigen::Matrix3d& rotation : pose.parent_from_joint) {
                const StoredRotation stored = rotation.cast<float>();
                rotations.insert(rotations.end(), stored.data(), stored.data() + 9);
            }
            translations.push_back(pose.root_translation);
        }
    }
    RowMatrix rows(static_cast<Eigen::Index>(translations.size()), 3);
    for (std::size_t f = 0; f < translations.size(); ++f) {
        rows.row(static_cast<Eigen::Index>(f)) = translations[f].transpose();
    }
    writer.write("/poses/joint_names", capture.joint_names, "joints in the order of /poses/rotations");
    writer.write("/poses/rotations", {translations.size(), joints, 9}, rotations.data(),
                 "from each joint's frame to its parent's, row by row");
    writer.write("/poses/root_translations", rows, "displacement of the root, m", Storage::float64);
}

Pose read_pose(const H5Reader& reader, const RowMatrix& translations, std::size_t joints, int frame)
{
    const std::vector<float> values = reader.read_slice("/poses/rotations", static_cast<std::size_t>(frame));
    Pose pose;
    pose.root_translation = translations.row(frame).transpose();
    for (std::size_t j = 0; j < joints; ++j) {
        const Eigen::Matrix3d rotation = Eigen::Map<const StoredRotation>(&values[9 * j]).cast<double>();
        require_input((rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).norm() < rotation_tolerance &&
                          rotation.determinant() > 0,
                      "{}: /poses/rotations of frame {}, joint {}, is no rotation", reader.path(), frame, j);
        pose.parent_from_joint.push_back(Eigen::Quaterniond(rotation).normalized().toRotationMatrix());
    }
    return pose;
}

}  // namespace

const CaptureSequence& Capture::sequence(const std::string& name) const
{
    for (const CaptureSequence& candidate : sequences) {
        if (candidate.name == name) return candidate;
    }
    throw InputError(
        fmt::format("{}: there is no sequence \"{}\" among the {} of the capture", subject, name, sequences.size()));
}

void Capture::check(const std::string& where) const
{
    require_input(!sequences.empty(), "{}: a capture without sequences", where);
    require_input(triangles.rows() > 0 && triangles.minCoeff() >= 0, "{}: a capture without a surface", where);
    const Eigen::Index count = sequences[0].vertices.empty() ? 0 : sequences[0].vertices[0].rows();
    require_input(triangles.maxCoeff() < count, "{}: a triangle has vertex {} of {}", where, triangles.maxCoeff(),
                  count);
    require_input(true_stiffness.empty() || static_cast<Eigen::Index>(true_stiffness.size()) == count,
                  "{}: true stiffness of {} vertices, there are {}", where, true_stiffness.size(), count);
    for (const CaptureSequence& s : sequences) {
        require_input(std::isfinite(s.frame_rate_hertz) && s.frame_rate_hertz > 0,
                      "{}: sequence \"{}\" has {} frames a second", where, s.name, s.frame_rate_hertz);
        require_input(s.num_frames() >= 2 && s.vertices.size() == s.frame_numbers.size(),
                      "{}: sequence \"{}\" has {} frames and numbers of {}; a motion has two at least", where, s.name,
                      s.vertices.size(), s.frame_numbers.size());
        require_input(s.poses.empty() != has_poses() && (s.poses.empty() || s.poses.size() == s.frame_numbers.size()),
                      "{}: sequence \"{}\" has {} poses for {} frames", where, s.name, s.poses.size(), s.num_frames());
        for (int f = 0; f < s.num_frames(); ++f) {
            const auto k = static_cast<std::size_t>(f);
            require_input(s.frame_numbers[k] >= 0 && (f == 0 || s.frame_numbers[k] > s.frame_numbers[k - 1]),
                          "{}: sequence \"{}\": frame number {} does not ascend", where, s.name, s.frame_numbers[k]);
            require_input(s.vertices[k].rows() == count, "{}: sequence \"{}\", frame {}: {} vertices instead of {}",
                          where, s.name, s.frame_numbers[k], s.vertices[k].rows(), count);
            require_input(s.vertices[k].allFinite(), "{}: sequence \"{}\", frame {}: a vertex is not finite", where,
                          s.name, s.frame_numbers[k]);
            require_input(s.poses.empty() || s.poses[k].parent_from_joint.size() == joint_names.size(),
                          "{}: sequence \"{}\", frame {}: a pose of another number of joints than {}", where, s.name,
                          s.frame_numbers[k], joint_names.size());
        }
    }
}

void write_capture(const std::string& path, const Capture& capture, const Provenance& provenance)
{
    capture.check(path);
    std::vector<std::string> names;
    std::vector<double> rates;
    std::vector<int> begins, numbers;
    for (const CaptureSequence& sequence : capture.sequences) {
        names.push_back(sequence.name);
        rates.push_back(sequence.frame_rate_hertz);
        begins.push_back(static_cast<int>(numbers.size()));
        numbers.insert(numbers.end(), sequence.frame_numbers.begin(), sequence.frame_numbers.end());
    }
    H5Writer writer(path, format_name, format_version, provenance);
    writer.attribute("subject", capture.subject);
    writer.write("/skin/triangles", capture.triangles, "indices into the vertices, outward");
    writer.write("/sequences/names", names, "names of the motions");
    writer.write("/sequences/frame_rates", rates, "frames a second");
    writer.write("/sequences/frame_begin", begins, "first frame of each");
    writer.write("/frames/numbers", numbers, "number of each frame in its recording; gaps are missing frames");
    const auto count = static_cast<std::size_t>(capture.sequences[0].vertices[0].rows());
    writer.create("/frames/vertices", {numbers.size(), count, 3}, "the surface, m");
    std::size_t frame = 0;
    for (const CaptureSequence& sequence : capture.sequences) {
        for (const Points& vertices : sequence.vertices) {
            const RowMatrixF stored = vertices.cast<float>();
            writer.write_slice("/frames/vertices", frame++, stored.data());
        }
    }
    if (capture.has_poses()) write_pose_arrays(writer, capture);
    if (!capture.true_stiffness.empty()) {
        writer.write("/truth/stiffness", capture.true_stiffness,
                     "of a twin: stiffness of the fat below each vertex over that of its kind, 0: no flesh");
    }
    writer.commit();
}

Capture read_capture(const std::string& path)
{
    const H5Reader reader(path, format_name, format_version);
    Capture capture;
    capture.subject = reader.attribute("subject");
    const std::vector<std::size_t> shape = reader.shape("/frames/vertices");
    require_input(shape.size() == 3 && shape[2] == 3 && shape[0] > 0 && shape[1] > 0,
                  "{}: /frames/vertices is not F x N x 3", path);
    const auto num_frames = static_cast<int>(shape[0]);
    capture.triangles = reader.read_int_matrix("/skin/triangles", -1, 3, 0,
                                               static_cast<int>(std::min<std::size_t>(shape[1], most_frames)) - 1);
    const std::vector<std::string> names = reader.read_strings("/sequences/names");
    const auto count = static_cast<std::int64_t>(names.size());
    const std::vector<double> rates = reader.read_doubles("/sequences/frame_rates", count);
    std::vector<int> begins = reader.read_ints("/sequences/frame_begin", count, 0, num_frames - 1);
    require_input(!begins.empty() && begins[0] == 0 &&
                      std::adjacent_find(begins.begin(), begins.end(), std::greater_equal<>()) == begins.end(),
                  "{}: /sequences/frame_begin does not begin with 0 and ascend", path);
    begins.push_back(num_frames);
    const std::vector<int> numbers = reader.read_ints("/frames/numbers", num_frames, 0, most_frames);
    const bool posed = reader.has("/poses/rotations");
    RowMatrix translations;
    if (posed) {
        capture.joint_names = reader.read_strings("/poses/joint_names");
        const std::vector<std::size_t> expected{shape[0], capture.joint_names.size(), 9};
        require_input(reader.shape("/poses/rotations") == expected, "{}: /poses/rotations is not {} x {} x 9", path,
                      shape[0], expected[1]);
        translations = reader.read_matrix("/poses/root_translations", num_frames, 3);
    }
    for (std::size_t s = 0; s < names.size(); ++s) {
        CaptureSequence sequence;
        sequence.name = names[s];
        sequence.frame_rate_hertz = rates[s];
        for (int f = begins[s]; f < begins[s + 1]; ++f) {
            sequence.frame_numbers.push_back(numbers[static_cast<std::size_t>(f)]);
            const std::vector<float> values = reader.read_slice("/frames/vertices", static_cast<std::size_t>(f));
            sequence.vertices.push_back(
                Eigen::Map<const RowMatrixF>(values.data(), static_cast<Eigen::Index>(shape[1]), 3).cast<double>());
            if (posed) sequence.poses.push_back(read_pose(reader, translations, capture.joint_names.size(), f));
        }
        capture.sequences.push_back(std::move(sequence));
    }
    if (reader.has("/truth/stiffness")) {
        capture.true_stiffness = reader.read_doubles("/truth/stiffness", static_cast<std::int64_t>(shape[1]));
    }
    capture.check(path);
    return capture;
}

}  // namespace ndg
