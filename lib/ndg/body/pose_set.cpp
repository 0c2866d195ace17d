// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/pose_set.h"

#include "ndg/body/stored_pose.h"
#include "ndg/core/error.h"
#include "ndg/io/h5.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ndg {

namespace {

constexpr const char* format_name = "ndg-poses";
constexpr int format_version = 1;
/// How far a stored matrix may be from a rotation; float32 storage alone stays below 1e-6.
constexpr double rotation_tolerance = 1e-4;

using StoredRotation = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;

/// The nearest rotation. Newton-Schulz iteration for the polar factor: an error of 1e-4 falls to 1e-8, then below
/// rounding; a matrix that is exactly orthonormal stays exactly as it is.
Eigen::Matrix3d orthonormalised(Eigen::Matrix3d rotation)
{
    for (int iteration = 0; iteration < 3; ++iteration) {
        rotation = (0.5 * rotation * (3.0 * Eigen::Matrix3d::Identity() - rotation.transpose() * rotation)).eval();
    }
    return rotation;
}

/// Each row of /poses/spliced_from has three clips with their frames, or -1 alone.
void check_sources(const std::string& path, const PoseSet& poses)
{
    const auto num_clips = static_cast<int>(poses.clip_names.size());
    for (Eigen::Index i = 0; i < poses.spliced_from.rows(); ++i) {
        const auto row = poses.spliced_from.row(i);
        if (row.maxCoeff() < 0) continue;
        require_input(row.minCoeff() >= 0, "{}: /poses/spliced_from[{}] has -1 beside clips and frames", path, i);
        for (int part = 0; part < 3; ++part)
            require_input(row[2 * part] < num_clips, "{}: /poses/spliced_from[{}] names clip {}, there are {}", path, i,
                          row[2 * part], num_clips);
    }
}

}  // namespace

void write_poses(const std::string& path, const PoseSet& poses, const Provenance& provenance)
{
    constexpr auto num_joints = static_cast<std::size_t>(num_standard_joints);
    const std::size_t count = poses.poses.size();
    require(count > 0, "There are no poses to write to {}", path);
    require(poses.clip_idx.size() == count && poses.frame_idx.size() == count,
            "{} poses were given {} clip and {} frame indices", count, poses.clip_idx.size(), poses.frame_idx.size());
    require(poses.clip_names.size() == poses.clip_frame_rates.size(), "{} clips were given {} frame rates",
            poses.clip_names.size(), poses.clip_frame_rates.size());
    require(poses.covering_radius.empty() || poses.covering_radius.size() == count,
            "{} poses were given {} covering radii", count, poses.covering_radius.size());
    require(poses.spliced_from.rows() == 0 ||
                (poses.spliced_from.rows() == static_cast<Eigen::Index>(count) && poses.spliced_from.cols() == 6),
            "{} poses were given {} x {} sources of splices", count, poses.spliced_from.rows(),
            poses.spliced_from.cols());

    std::vector<float> rotations(count * num_joints * 9);
    RowMatrix translations(static_cast<Eigen::Index>(count), 3);
    for (std::size_t i = 0; i < count; ++i) {
        const Pose& pose = poses.poses[i];
        require(pose.parent_from_joint.size() == num_joints, "Pose {} has {} joint rotations instead of {}", i,
                pose.parent_from_joint.size(), num_joints);
        for (std::size_t j = 0; j < num_joints; ++j) {
            Eigen::Map<StoredRotation> stored(&rotations[(i * num_joints + j) * 9]);
            stored = pose.parent_from_joint[j].cast<float>();
        }
        translations.row(static_cast<Eigen::Index>(i)) = pose.root_translation.transpose();
    }

    H5Writer writer(path, format_name, format_version, provenance);
    writer.write("/skeleton/joint_names", standard_skeleton().joint_names, "joints in the order of /poses/rotations");
    writer.write("/poses/rotations", {count, num_joints, 9}, rotations.data(),
                 "row-major rotation of each joint, from joint frame to parent frame");
    writer.write("/poses/root_translations", translations, "world displacement of the root joint, m", Storage::float64);
    writer.write("/poses/clip_idx", poses.clip_idx, "clip of each pose, into /clips/names");
    writer.write("/poses/frame_idx", poses.frame_idx, "frame of that clip");
    writer.write("/poses/covering_radius", poses.covering_radius,
                 "largest distance of an unpicked pose after each pick, rad summed over joints; may be empty");
    if (poses.spliced_from.rows() > 0)
        writer.write("/poses/spliced_from", poses.spliced_from,
                     "clip and frame of trunk and head, of the arms and of the legs; -1: not spliced");
    writer.write("/clips/names", poses.clip_names, "names of the motion clips");
    writer.write("/clips/frame_rates", poses.clip_frame_rates, "frame rates of the clips, Hz");
    writer.commit();
}

PoseSet read_poses(const std::string& path)
{
    constexpr auto num_joints = static_cast<std::size_t>(num_standard_joints);
    const H5Reader reader(path, format_name, format_version);
    const std::vector<std::string> joint_names = reader.read_strings("/skeleton/joint_names", num_standard_joints);
    for (std::size_t j = 0; j < num_joints; ++j) {
        require_input(joint_names[j] == standard_skeleton().joint_names[j],
                      "{}: /skeleton/joint_names[{}] is \"{}\" instead of \"{}\"", path, j, joint_names[j],
                      standard_skeleton().joint_names[j]);
    }

    PoseSet poses;
    poses.clip_names = reader.read_strings("/clips/names");
    poses.clip_frame_rates =
        reader.read_doubles("/clips/frame_rates", static_cast<std::int64_t>(poses.clip_names.size()));
    const std::vector<std::size_t> shape = reader.shape("/poses/rotations");
    require_input(shape.size() == 3 && shape[0] > 0 && shape[1] == num_joints && shape[2] == 9,
                  "{}: /poses/rotations has shape {} instead of poses x {} x 9", path, fmt::join(shape, " x "),
                  num_joints);
    const auto count = static_cast<std::int64_t>(shape[0]);
    const RowMatrix translations = reader.read_matrix("/poses/root_translations", count, 3);
    poses.clip_idx = reader.read_ints("/poses/clip_idx", count, 0, static_cast<int>(poses.clip_names.size()) - 1);
    poses.frame_idx = reader.read_ints("/poses/frame_idx", count, 0, std::numeric_limits<int>::max());
    poses.covering_radius = reader.read_doubles("/poses/covering_radius");
    require_input(poses.covering_radius.empty() || poses.covering_radius.size() == shape[0],
                  "{}: /poses/covering_radius has {} values for {} poses", path, poses.covering_radius.size(), count);

    if (reader.has("/poses/spliced_from")) {
        poses.spliced_from =
            reader.read_int_matrix("/poses/spliced_from", count, 6, -1, std::numeric_limits<int>::max());
        check_sources(path, poses);
    }

    poses.poses.resize(shape[0]);
    for (std::size_t i = 0; i < shape[0]; ++i) {
        Pose& pose = poses.poses[i];
        const std::vector<float> stored = reader.read_slice("/poses/rotations", i);
        pose.parent_from_joint.resize(num_joints);
        for (std::size_t j = 0; j < num_joints; ++j) {
            const Eigen::Matrix3d matrix = Eigen::Map<const StoredRotation>(&stored[j * 9]).cast<double>();
            const Eigen::Matrix3d defect = matrix * matrix.transpose() - Eigen::Matrix3d::Identity();
            double largest = 0.0;
            for (Eigen::Index k = 0; k < 9; ++k) largest = std::max(largest, std::abs(defect.data()[k]));
            require_input(
                largest <= rotation_tolerance && matrix.determinant() > 0.0,
                "{}: /poses/rotations[{}, {}] is no rotation (departs from orthonormal by {}, determinant {})", path, i,
                j, largest, matrix.determinant());
            pose.parent_from_joint[j] = orthonormalised(matrix);
        }
        pose.root_translation = translations.row(static_cast<Eigen::Index>(i)).transpose();
    }
    return poses;
}

Pose as_stored(const Pose& pose)
{
    Pose stored = pose;
    for (Eigen::Matrix3d& rotation : stored.parent_from_joint)
        rotation = orthonormalised(rotation.cast<float>().cast<double>());
    return stored;
}

}  // namespace ndg
