// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/rest_offsets.h"

#include "ndg/core/error.h"

#include <Eigen/LU>
#include <Eigen/SVD>

namespace ndg {

namespace {

Eigen::Matrix<double, 3, 4> blended_motion(const SkinningWeights& weights, const PosedBody& posed, int vertex)
{
    Eigen::Matrix<double, 3, 4> blend = Eigen::Matrix<double, 3, 4>::Zero();
    for (int k = 0; k < max_influences; ++k)
        blend += weights.weights(vertex, k) * posed.world_from_rest()[weights.joints(vertex, k)].matrix().topRows<3>();
    return blend;
}

}  // namespace

RestOffsets::RestOffsets(const Template& body_template)
    : num_wrap_(body_template.num_wrap_vertices()), weights_(body_template.volume_weights())
{
}

Points RestOffsets::offsets(const PosedBody& posed, const Eigen::Ref<const PointsF>& vertices) const
{
    const Points& rest = posed.body().volume_vertices;
    require(vertices.rows() == rest.rows(), "{} deformed vertices, the body at rest has {}", vertices.rows(),
            rest.rows());
    Points offsets(num_vertices(), 3);
    for (int i = 0; i < num_vertices(); ++i) {
        const int v = num_wrap_ + i;
        const Eigen::Matrix<double, 3, 4> blend = blended_motion(weights_, posed, v);
        const Eigen::Vector3d skinned = blend * rest.row(v).transpose().homogeneous();
        const Eigen::Vector3d moved = vertices.row(v).transpose().cast<double>();
        const Eigen::Vector3d offset = bounded_inverse(blend.leftCols<3>()) * (moved - skinned);
        offsets.row(i) = offset.transpose();
    }
    return offsets;
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
