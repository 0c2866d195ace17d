// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/rest_offsets.h"

#include "ndg/core/error.h"

#include <Eigen/LU>
#include <Eigen/SVD>

namespace ndg {

Eigen::Matrix<double, 3, 4> blended_motion(const SkinningWeights& weights,
                                           const std::vector<Eigen::Isometry3d>& world_from_rest, int vertex)
{
    Eigen::Matrix<double, 3, 4> blend = Eigen::Matrix<double, 3, 4>::Zero();
    for (int k = 0; k < max_influences; ++k)
        blend += weights.weights(vertex, k) * world_from_rest[weights.joints(vertex, k)].matrix().topRows<3>();
    return blend;
}

Points rest_offsets(const Eigen::Ref<const Points>& rest, const SkinningWeights& weights,
                    const std::vector<Eigen::Isometry3d>& world_from_rest, const Eigen::Ref<const Points>& deformed)
{
    require(deformed.rows() == rest.rows() && weights.size() == rest.rows(),
            "{} deformed vertices, the body at rest has {}", deformed.rows(), rest.rows());
    Points offsets(rest.rows(), 3);
    for (int v = 0; v < int(rest.rows()); ++v) {
        const Eigen::Matrix<double, 3, 4> blend = blended_motion(weights, world_from_rest, v);
        const Eigen::Vector3d skinned = blend * rest.row(v).transpose().homogeneous();
        const Eigen::Vector3d offset = bounded_inverse(blend.leftCols<3>()) * (deformed.row(v).transpose() - skinned);
        offsets.row(v) = offset.transpose();
    }
    return offsets;
}

RestOffsets::RestOffsets(const Template& body_template)
    : num_wrap_(body_template.num_wrap_vertices()), weights_(body_template.volume_weights())
{
    free_weights_.joints = weights_.joints.bottomRows(num_vertices());
    free_weights_.weights = weights_.weights.bottomRows(num_vertices());
}

Points RestOffsets::offsets(const PosedBody& posed, const Eigen::Ref<const PointsF>& vertices) const
{
    const Points& rest = posed.body().volume_vertices;
    require(vertices.rows() == rest.rows(), "{} deformed vertices, the body at rest has {}", vertices.rows(),
            rest.rows());
    return rest_offsets(rest.bottomRows(num_vertices()), free_weights_, posed.world_from_rest(),
                        vertices.bottomRows(num_vertices()).cast<double>());
}

Points RestOffsets::vertices(const PosedBody& posed, const Eigen::Ref<const Points>& offsets) const
{
    require(offsets.rows() == num_vertices(), "{} offsets, the template has {} free vertices", offsets.rows(),
            num_vertices());
    Points rest = posed.body().volume_vertices;
    rest.bottomRows(num_vertices()) += offsets;
    Points deformed = linear_blend_skinning(rest, weights_, posed.world_from_rest());
    deformed.topRows(num_wrap_) = posed.bone_wrap();
    return deformed;
}

Eigen::Matrix3d bounded_inverse(const Eigen::Matrix3d& blend, double least)
{
    // Means of rotations stretch nothing, so the determinant is at most the smallest stretch.
    if (blend.determinant() >= least) return blend.inverse();
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(blend, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Eigen::Vector3d inverse = svd.singularValues().unaryExpr(
        [least](double stretch) { return stretch < least ? stretch / (least * least) : 1.0 / stretch; });
    return svd.matrixV() * inverse.asDiagonal() * svd.matrixU().transpose();
}

}  // namespace ndg
