// SPDX-License-Identifier: Apache-2.0
#include "ndg/capture/motion_variance.h"

#include "ndg/core/error.h"

#include <Eigen/LU>

namespace ndg {

namespace {

Points unposed(const Points& world, const std::vector<int>& rows, const std::vector<int>& volume_vertices,
               const std::vector<AffineMap>& world_from_unposed)
{
    Points result(static_cast<Eigen::Index>(rows.size()), 3);
    for (std::size_t v = 0; v < rows.size(); ++v) {
        const AffineMap& map = world_from_unposed[static_cast<std::size_t>(volume_vertices[v])];
        const Eigen::Vector3d x = world.row(rows[v]).transpose();
        const Eigen::Vector3d u = map.leftCols<3>().inverse() * (x - map.col(3));
        result.row(static_cast<Eigen::Index>(v)) = u.transpose();
    }
    return result;
}

}  // namespace

Eigen::VectorXd MotionVariance::stacked() const
{
    Eigen::VectorXd both(normal.size() + tangent.size());
    both << normal, tangent;
    return both;
}

MotionVarianceSum::MotionVarianceSum(const Points& reference, const Points& normals)
    : reference_(reference),
      normals_(normals),
      sum_(Points::Zero(reference.rows(), 3)),
      squares_(Eigen::VectorXd::Zero(reference.rows())),
      normal_sum_(squares_),
      normal_squares_(squares_)
{
    require(normals.rows() == reference.rows(), "{} normals for {} vertices", normals.rows(), reference.rows());
    for (Eigen::Index v = 0; v < normals.rows(); ++v) {
        const double length = normals.row(v).norm();
        require(length > 1e-9, "the normal of vertex {} has the length {}", v, length);
        normals_.row(v) /= length;
    }
}

void MotionVarianceSum::add(const Points& unposed_positions)
{
    require(unposed_positions.rows() == reference_.rows(), "{} positions for {} vertices", unposed_positions.rows(),
            reference_.rows());
    const Points offset = unposed_positions - reference_;
    const Eigen::VectorXd along = offset.cwiseProduct(normals_).rowwise().sum();
    sum_ += offset;
    squares_ += offset.rowwise().squaredNorm();
    normal_sum_ += along;
    normal_squares_ += along.cwiseAbs2();
    ++num_frames_;
}

MotionVariance MotionVarianceSum::variance() const
{
    require(num_frames_ > 0, "the variance of no frames was asked for");
    const double count = num_frames_;
    MotionVariance result;
    result.normal = (normal_squares_ / count - (normal_sum_ / count).cwiseAbs2()).cwiseMax(0.0);
    const Eigen::VectorXd total = squares_ / count - (sum_ / count).rowwise().squaredNorm();
    result.tangent = (total - result.normal).cwiseMax(0.0);
    return result;
}

Points MotionVarianceSum::mean() const
{
    require(num_frames_ > 0, "the mean of no frames was asked for");
    return reference_ + sum_ / num_frames_;
}

MeasuredSkin::MeasuredSkin(const Avatar& avatar)
{
    for (std::size_t s = 0; s < avatar.volume_vertex_of_skin.size(); ++s) {
        const int v = avatar.volume_vertex_of_skin[s];
        if (v < avatar.num_held) continue;
        skin_vertices.push_back(static_cast<int>(s));
        volume_vertices.push_back(v);
    }
    require(!skin_vertices.empty(), "avatar {} has no skin that is free to move", avatar.name);
    rest.resize(size(), 3);
    normals.resize(size(), 3);
    for (int v = 0; v < size(); ++v) {
        rest.row(v) = avatar.rest.row(volume_vertices[static_cast<std::size_t>(v)]);
        normals.row(v) = avatar.normals.row(volume_vertices[static_cast<std::size_t>(v)]);
    }
}

Points MeasuredSkin::unposed_skin(const Points& skin, const std::vector<AffineMap>& world_from_unposed) const
{
    return unposed(skin, skin_vertices, volume_vertices, world_from_unposed);
}

Points MeasuredSkin::unposed_volume(const Points& volume, const std::vector<AffineMap>& world_from_unposed) const
{
    return unposed(volume, volume_vertices, volume_vertices, world_from_unposed);
}

MotionVariance motion_variance(const Avatar& avatar, const MeasuredSkin& skin, const CaptureSequence& sequence)
{
    require_input(!sequence.poses.empty(), "sequence \"{}\" has no poses, by which its skin could be unposed",
                  sequence.name);
    const AvatarPoser poser(avatar);
    MotionVarianceSum sum(skin.rest, skin.normals);
    for (std::size_t f = 0; f < sequence.vertices.size(); ++f) {
        require_input(sequence.vertices[f].rows() == avatar.skin_vertices.rows(),
                      "sequence \"{}\" has {} vertices, the skin of avatar {} has {}", sequence.name,
                      sequence.vertices[f].rows(), avatar.name, avatar.skin_vertices.rows());
        sum.add(skin.unposed_skin(sequence.vertices[f], poser.world_from_unposed(sequence.poses[f])));
    }
    return sum.variance();
}

double variance_error(const MotionVariance& a, const MotionVariance& b, VarianceMetric metric)
{
    require(a.normal.size() == b.normal.size(), "motions of {} and {} vertices were compared", a.normal.size(),
            b.normal.size());
    if (metric == VarianceMetric::isotropic) return (a.total() - b.total()).squaredNorm();
    return (a.stacked() - b.stacked()).squaredNorm();
}

}  // namespace ndg
