// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/poisson.h"

#include "ndg/core/error.h"
#include "ndg/deform/poisson_matrices.h"

#include <utility>

namespace ndg {

PoissonReconstruction::PoissonReconstruction(const RestOperators& rest, int num_wrap_vertices)
    : prisms_(rest.prisms()),
      num_wrap_vertices_(num_wrap_vertices),
      num_vertices_(rest.num_vertices()),
      weighted_operators_(rest.num_prisms()),
      cholesky_(SparseCholesky::Method::simplicial)
{
    require(num_wrap_vertices_ > 0 && num_wrap_vertices_ < num_vertices_,
            "{} bone wrap vertices among {} volume vertices leave nothing to solve for", num_wrap_vertices_,
            num_vertices_);
    set_rest(rest);
}

void PoissonReconstruction::set_rest(const RestOperators& rest)
{
    require(rest.num_vertices() == num_vertices_ && rest.num_prisms() == num_prisms(),
            "the body has {} volume vertices and {} prisms, the template {} and {}", rest.num_vertices(),
            rest.num_prisms(), num_vertices_, num_prisms());
    for (int p = 0; p < num_prisms(); ++p) weighted_operators_[p] = rest.volume(p) * rest.gradient(p).transpose();
    PoissonMatrices matrices(rest, num_wrap_vertices_);
    coupling_ = std::move(matrices.coupling);
    if (!analyzed_) cholesky_.analyze(matrices.free);
    analyzed_ = true;
    if (!cholesky_.factorize(matrices.free)) {
        throw SolverError("the Poisson system is not positive definite: some vertex is not held by the bone wrap");
    }
}

template <typename GradientAt>
Points PoissonReconstruction::solve(const GradientAt& gradient_at, const Eigen::Ref<const Points>& bone_wrap) const
{
    require(bone_wrap.rows() == num_wrap_vertices_, "{} bone wrap vertices given, the template has {}",
            bone_wrap.rows(), num_wrap_vertices_);
    const int num_free = num_vertices_ - num_wrap_vertices_;
    Points scattered = Points::Zero(num_free, 3);
    for (Eigen::Index p = 0; p < prisms_.rows(); ++p) {
        // G^T W takes F_p^T, three rows a prism with the same weight.
        const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> transposed = gradient_at(p).transpose();
        const WeightedOperator force = weighted_operators_[p].lazyProduct(transposed);
        for (int a = 0; a < 6; ++a) {
            const int row = prisms_(p, a) - num_wrap_vertices_;
            if (row >= 0) scattered.row(row) += force.row(a);
        }
    }
    Eigen::MatrixXd right_hand_side = scattered;
    right_hand_side.noalias() -= coupling_ * bone_wrap;

    Points vertices(num_vertices_, 3);
    vertices.topRows(num_wrap_vertices_) = bone_wrap;
    vertices.bottomRows(num_free) = cholesky_.solve(right_hand_side);
    return vertices;
}

Points PoissonReconstruction::reconstruct(const Eigen::Ref<const Gradients>& gradients,
                                          const Eigen::Ref<const Points>& bone_wrap) const
{
    require(gradients.rows() == prisms_.rows(), "{} deformation gradients given, the template has {} prisms",
            gradients.rows(), prisms_.rows());
    return solve(
        [&](Eigen::Index p) {
            return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(gradients.row(p).data());
        },
        bone_wrap);
}

Points PoissonReconstruction::reconstruct(const Eigen::Ref<const GradientsF>& gradients,
                                          const Eigen::Ref<const Points>& bone_wrap) const
{
    require(gradients.rows() == prisms_.rows(), "{} deformation gradients given, the template has {} prisms",
            gradients.rows(), prisms_.rows());
    return solve(
        [&](Eigen::Index p) -> Eigen::Matrix3d {
            return Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(gradients.row(p).data())
                .cast<double>();
        },
        bone_wrap);
}

Points PoissonReconstruction::reconstruct(const std::vector<Eigen::Matrix3d>& prism_rotations,
                                          const Eigen::Ref<const Points>& bone_wrap) const
{
    require(static_cast<Eigen::Index>(prism_rotations.size()) == prisms_.rows(),
            "{} prism rotations given, the template has {} prisms", prism_rotations.size(), prisms_.rows());
    return solve([&](Eigen::Index p) { return prism_rotations[p]; }, bone_wrap);
}

}  // namespace ndg
