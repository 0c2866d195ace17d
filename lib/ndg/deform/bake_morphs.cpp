// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/bake_morphs.h"

#include "ndg/core/error.h"
#include "ndg/deform/rest_offsets.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>

namespace ndg {
namespace {

FrameError frame_error(const Points& vertices, const Points& wanted)
{
    const Eigen::VectorXd distances = (vertices - wanted).rowwise().norm();
    return {distances.mean(), distances.maxCoeff()};
}

/// Leading right singular vectors of `offsets` (frames x 3 N) as columns, by the eigenvectors of the smaller Gram
/// matrix; those without a share of the largest are left out.
Eigen::MatrixXd principal_directions(const Eigen::MatrixXd& offsets, int max_count)
{
    constexpr double least_share = 1e-12;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> gram(offsets * offsets.transpose());
    const Eigen::VectorXd& values = gram.eigenvalues();  // ascending
    int count = 0;
    const Eigen::Index last = values.size() - 1;
    while (count < max_count && count <= last && values[last - count] > least_share * std::max(values[last], 1e-18))
        ++count;
    Eigen::MatrixXd directions = offsets.transpose() * gram.eigenvectors().rightCols(count).rowwise().reverse();
    directions.colwise().normalize();
    return directions;
}

/// Columns of `directions` (3 N x K) turned by the blend of joint motions of each vertex.
Eigen::MatrixXd posed_directions(const Eigen::MatrixXd& directions, const SkinningWeights& weights,
                                 const std::vector<Eigen::Isometry3d>& world_from_rest)
{
    Eigen::MatrixXd posed(directions.rows(), directions.cols());
    for (int v = 0; v < int(weights.size()); ++v)
        posed.middleRows<3>(3 * v) =
            blended_motion(weights, world_from_rest, v).leftCols<3>() * directions.middleRows<3>(3 * v);
    return posed;
}

Eigen::Map<const Eigen::VectorXd> flat(const Points& points)
{
    return {points.data(), points.size()};
}

}  // namespace

BakedMorphs bake_morphs(const Points& rest, const SkinningWeights& weights, int num_frames, int max_morphs,
                        const std::function<BakedFrame(int frame_idx)>& frame)
{
    require(num_frames > 0 && max_morphs > 0, "{} morphs of {} frames", max_morphs, num_frames);
    Eigen::MatrixXd offsets(num_frames, rest.size());
    for (int f = 0; f < num_frames; ++f) {
        const BakedFrame wanted = frame(f);
        offsets.row(f) = flat(rest_offsets(rest, weights, wanted.world_from_rest, wanted.vertices)).transpose();
    }
    Eigen::MatrixXd directions = principal_directions(offsets, max_morphs);
    const Eigen::Index count = directions.cols();
    BakedMorphs baked;
    baked.weights.resize(num_frames, count);
    for (int f = 0; f < num_frames; ++f) {
        const BakedFrame wanted = frame(f);
        const Points skinned = linear_blend_skinning(rest, weights, wanted.world_from_rest);
        const Points missing = wanted.vertices - skinned;
        const Eigen::MatrixXd posed = posed_directions(directions, weights, wanted.world_from_rest);
        // The directions are orthonormal and blends stretch by at most one: far below that they are not seen at all.
        Eigen::MatrixXd normal = posed.transpose() * posed;
        normal.diagonal().array() += 1e-6;
        const Eigen::VectorXd fitted = normal.llt().solve(posed.transpose() * flat(missing));
        baked.weights.row(f) = fitted.transpose();
        Points vertices = skinned;
        Eigen::Map<Eigen::VectorXd>(vertices.data(), vertices.size()) += posed * fitted;
        baked.errors.push_back(frame_error(vertices, wanted.vertices));
        baked.skinning_errors.push_back(frame_error(skinned, wanted.vertices));
    }
    for (Eigen::Index k = 0; k < count; ++k) {
        const double largest = std::max(baked.weights.col(k).cwiseAbs().maxCoeff(), 1e-12);
        baked.weights.col(k) /= largest;
        directions.col(k) *= largest;
        baked.morphs.emplace_back(Eigen::Map<const Points>(directions.col(k).data(), rest.rows(), 3));
    }
    return baked;
}

}  // namespace ndg
