// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/vertex_offsets.h"

#include "ndg/core/error.h"

#include <Eigen/LU>
#include <Eigen/SVD>

namespace ndg {
namespace {

constexpr double mm = 1e-3;

class VertexOffsets : public OutputSpace {
public:
    explicit VertexOffsets(const Template& body_template)
        : num_wrap_(body_template.num_wrap_vertices()), weights_(body_template.volume_weights())
    {
    }

    int width() const override { return 6 * num_wrap_; }
    OutputKind kind() const override { return OutputKind::vertex_vectors; }

    std::string script() const override { return "    return 0.001 * y.reshape(y.size(0), -1, 3)\n"; }

    void target(const PosedBody& posed, const RestOperators&, const Eigen::Ref<const PointsF>& vertices,
                float* target) const override
    {
        const Points& rest = posed.body().volume_vertices;
        for (int i = 0; i < 2 * num_wrap_; ++i) {
            const int v = num_wrap_ + i;
            const Eigen::Matrix<double, 3, 4> blend = blended_motion(posed, v);
            const Eigen::Vector3d skinned = blend * rest.row(v).transpose().homogeneous();
            const Eigen::Vector3d moved = vertices.row(v).transpose().cast<double>();
            const Eigen::Vector3d offset = bounded_inverse(blend.leftCols<3>()) * (moved - skinned);
            Eigen::Map<Eigen::Vector3f>(target + 3 * i) = (offset / mm).cast<float>();
        }
    }

    Points vertices(const PosedBody& posed, RestCache&, const float* prediction) const override
    {
        Points rest = posed.body().volume_vertices;
        rest.bottomRows(2 * num_wrap_) += mm * Eigen::Map<const PointsF>(prediction, 2 * num_wrap_, 3).cast<double>();
        Points deformed = linear_blend_skinning(rest, weights_, posed.world_from_rest());
        deformed.topRows(num_wrap_) = posed.bone_wrap();
        return deformed;
    }

private:
    Eigen::Matrix<double, 3, 4> blended_motion(const PosedBody& posed, int vertex) const
    {
        Eigen::Matrix<double, 3, 4> blend = Eigen::Matrix<double, 3, 4>::Zero();
        for (int k = 0; k < max_influences; ++k)
            blend +=
                weights_.weights(vertex, k) * posed.world_from_rest()[weights_.joints(vertex, k)].matrix().topRows<3>();
        return blend;
    }

    int num_wrap_;
    SkinningWeights weights_;  ///< of the volume vertices
};

}  // namespace

Eigen::Matrix3d bounded_inverse(const Eigen::Matrix3d& blend, double least)
{
    // Means of rotations stretch nothing, so the determinant is at most the smallest stretch.
    if (blend.determinant() >= least) return blend.inverse();
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(blend, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Eigen::Vector3d inverse = svd.singularValues().unaryExpr(
        [least](double stretch) { return stretch < least ? stretch / (least * least) : 1.0 / stretch; });
    return svd.matrixV() * inverse.asDiagonal() * svd.matrixU().transpose();
}

std::unique_ptr<OutputSpace> make_vertex_offsets(const Template& body_template, const NetworkOptions&)
{
    return std::make_unique<VertexOffsets>(body_template);
}

}  // namespace ndg
