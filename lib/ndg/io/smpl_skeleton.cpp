// SPDX-License-Identifier: Apache-2.0
#include "ndg/io/smpl_skeleton.h"

#include "ndg/core/error.h"
#include "ndg/io/npz.h"

#include <fmt/ranges.h>

#include <algorithm>

namespace ndg {

namespace {

NpyArray read_array(const NpzFile& file, const std::string& key, std::size_t rank)
{
    NpyArray array = file.read(key);
    require_input(array.shape.size() == rank && !array.values.empty(),
                  "{}: \"{}\" has the shape ({}), {} numbers above 0 are needed", file.path(), key,
                  fmt::join(array.shape, ", "), rank);
    return array;
}

void require_extent(const NpzFile& file, const std::string& key, std::int64_t extent, std::int64_t needed)
{
    require_input(extent == needed, "{}: \"{}\" has {} where {} are needed", file.path(), key, extent, needed);
}

Points as_points(const NpyArray& array)
{
    return Eigen::Map<const Points>(array.values.data(), array.shape[0], 3);
}

/// Rows of SMPL's joints, the same in the whole family.
constexpr int left_hip = 1, left_ankle = 7, left_foot = 10, head = 15, left_wrist = 20;

}  // namespace

SmplSkeleton::SmplSkeleton(const std::string& path)
{
    const NpzFile file(path);
    if (file.has("J_regressor")) {
        const NpyArray regressor = read_array(file, "J_regressor", 2), vertices = read_array(file, "v_template", 2);
        const std::int64_t num_vertices = vertices.shape[0];
        require_extent(file, "v_template", vertices.shape[1], 3);
        require_extent(file, "J_regressor", regressor.shape[1], num_vertices);
        using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
        const Eigen::Map<const Rows> joints_from_vertices(regressor.values.data(), regressor.shape[0], num_vertices);
        mean_ = joints_from_vertices * as_points(vertices);
        if (file.has("shapedirs")) {
            const NpyArray shapes = read_array(file, "shapedirs", 3);
            require_extent(file, "shapedirs", shapes.shape[0], num_vertices);
            require_extent(file, "shapedirs", shapes.shape[1], 3);
            const std::int64_t num_shapes = shapes.shape[2];
            const Eigen::Map<const Rows> all(shapes.values.data(), num_vertices, 3 * num_shapes);
            const Rows joints_of_shapes = joints_from_vertices * all;
            for (std::int64_t b = 0; b < num_shapes; ++b) {
                Points direction(mean_.rows(), 3);
                for (int k = 0; k < 3; ++k) direction.col(k) = joints_of_shapes.col(k * num_shapes + b);
                directions_.push_back(direction);
            }
        }
    } else {
        const NpyArray joints = read_array(file, "J", 2);
        require_extent(file, "J", joints.shape[1], 3);
        mean_ = as_points(joints);
    }
    require_input(mean_.rows() == 24 || mean_.rows() == 52 || mean_.rows() == 55,
                  "{}: has {} joints; SMPL has 24, SMPL-H 52, SMPL-X 55", path, mean_.rows());
    const Eigen::RowVector3d pelvis = mean_.row(0);
    const double stature = mean_(head, 1) - mean_(left_ankle, 1);
    const bool stands = stature > 0.5 && stature < 3.0 && mean_(left_hip, 0) > pelvis.x() &&
                        mean_(left_wrist, 0) > mean_(left_hip, 0) && mean_(left_foot, 2) > mean_(left_ankle, 2);
    require_input(stands,
                  "{}: its joints are no person in metres, y up, facing +z, the left side at +x (head {:.4g} above the "
                  "ankle, left hip at x {:.4g} from the pelvis)",
                  path, stature, mean_(left_hip, 0) - pelvis.x());
}

Points SmplSkeleton::joints(const std::vector<double>& betas) const
{
    Points joints = mean_;
    for (std::size_t b = 0; b < std::min(betas.size(), directions_.size()); ++b) joints += betas[b] * directions_[b];
    return joints;
}

}  // namespace ndg
