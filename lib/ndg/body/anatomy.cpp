// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/anatomy.h"

#include "ndg/core/error.h"

#include <Eigen/SVD>

namespace ndg {

namespace {

/// Skin with less weight than this on a joint says nothing about its place; the joint then follows its parent.
constexpr double min_joint_weight = 2.0;

using Similarity = Eigen::Transform<double, 3, Eigen::AffineCompact>;

/// Least-squares similarity of weighted points (Umeyama 1991), for every joint.
std::vector<Similarity> joint_similarities(const Template& body_template, const Body& body)
{
    const Points& from = body_template.rest.skin_vertices;
    const Points& to = body.skin_vertices;
    const SkinningWeights& weights = body_template.skin_weights;
    const auto num_joints = static_cast<std::size_t>(body_template.skeleton.num_joints());
    struct Sums {
        double weight = 0.0;
        Eigen::Vector3d from = Eigen::Vector3d::Zero(), to = Eigen::Vector3d::Zero();
        double spread = 0.0;
        Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    };
    std::vector<Sums> sums(num_joints);
    const auto for_each_weight = [&](auto&& visit) {
        for (Eigen::Index v = 0; v < from.rows(); ++v)
            for (int k = 0; k < max_influences; ++k)
                if (weights.weights(v, k) > 0.0) visit(sums[weights.joints(v, k)], weights.weights(v, k), v);
    };
    for_each_weight([&](Sums& s, double weight, Eigen::Index v) {
        s.weight += weight;
        s.from += weight * from.row(v).transpose();
        s.to += weight * to.row(v).transpose();
    });
    for (Sums& s : sums) {
        if (s.weight < min_joint_weight) continue;
        s.from /= s.weight;
        s.to /= s.weight;
    }
    for_each_weight([&](Sums& s, double weight, Eigen::Index v) {
        if (s.weight < min_joint_weight) return;
        const Eigen::Vector3d d = from.row(v).transpose() - s.from;
        s.spread += weight * d.squaredNorm();
        s.covariance += weight * (to.row(v).transpose() - s.to) * d.transpose();
    });
    std::vector<Similarity> body_from_template(num_joints, Similarity::Identity());
    for (std::size_t j = 0; j < num_joints; ++j) {
        const Sums& s = sums[j];
        if (s.weight < min_joint_weight || s.spread <= 0.0) {
            const int parent = body_template.skeleton.parents[j];
            if (parent >= 0) body_from_template[j] = body_from_template[parent];
            continue;
        }
        const Eigen::JacobiSVD<Eigen::Matrix3d> svd(s.covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
        Eigen::Vector3d sign = Eigen::Vector3d::Ones();
        if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) sign[2] = -1.0;
        const Eigen::Matrix3d rotation = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
        const double scale = svd.singularValues().dot(sign) / s.spread;
        body_from_template[j].linear() = scale * rotation;
        body_from_template[j].translation() = s.to - scale * rotation * s.from;
    }
    return body_from_template;
}

/// Overwrites the rows that are not embedded by their points moved by the blend of `transforms`.
template <typename Transforms>
void skin_free_rows(const Template& body_template, const Eigen::Ref<const Points>& rest, const Transforms& transforms,
                    Points& points)
{
    const SkinningWeights& weights = body_template.anatomy_weights;
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        if (body_template.embedding.elements[i] >= 0) continue;
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (int k = 0; k < max_influences; ++k)
            if (weights.weights(i, k) > 0.0)
                sum += weights.weights(i, k) * (transforms[weights.joints(i, k)] * rest.row(i).transpose());
        points.row(i) = sum.transpose();
    }
}

}  // namespace

SkinningWeights embedded_weights(const Embedding& embedding, const SkinningWeights& volume_weights,
                                 const SkinningWeights& interior_weights, int num_joints)
{
    const Eigen::Index count = embedding.weights.rows();
    RowMatrix dense = RowMatrix::Zero(count, num_joints);
    for (Eigen::Index i = 0; i < count; ++i) {
        if (embedding.elements[i] < 0) {
            dense(i, 0) = 1.0;
            continue;
        }
        for (int corner = 0; corner < 6; ++corner) {
            const double share = embedding.weights(i, corner);
            if (share <= 0.0) continue;
            const Eigen::Index vertex = embedding.vertices(i, corner);
            const bool in_volume = vertex < volume_weights.size();
            const SkinningWeights& source = in_volume ? volume_weights : interior_weights;
            const Eigen::Index row = in_volume ? vertex : vertex - volume_weights.size();
            for (int k = 0; k < max_influences; ++k) dense(i, source.joints(row, k)) += share * source.weights(row, k);
        }
    }
    return sparsify_weights(dense);
}

Points anatomy_at_rest(const Template& body_template, const Body& body)
{
    if (body_template.anatomy_vertices.rows() == 0) return Points(0, 3);
    require(body.skin_vertices.rows() == body_template.rest.skin_vertices.rows(),
            "body {} has {} skin vertices, the template {}", body.name, body.skin_vertices.rows(),
            body_template.rest.skin_vertices.rows());
    Points points = apply_embedding(body_template.embedding, body.volume_vertices, body.interior_vertices);
    skin_free_rows(body_template, body_template.anatomy_vertices, joint_similarities(body_template, body), points);
    return points;
}

Points deformed_anatomy(const Template& body_template, const Eigen::Ref<const Points>& anatomy_rest,
                        const Eigen::Ref<const Points>& volume_vertices,
                        const Eigen::Ref<const Points>& interior_vertices,
                        const std::vector<Eigen::Isometry3d>& world_from_rest)
{
    require(anatomy_rest.rows() == body_template.anatomy_vertices.rows(),
            "{} anatomy vertices at rest, the template has {}", anatomy_rest.rows(),
            body_template.anatomy_vertices.rows());
    Points points = apply_embedding(body_template.embedding, volume_vertices, interior_vertices);
    skin_free_rows(body_template, anatomy_rest, world_from_rest, points);
    return points;
}

}  // namespace ndg
