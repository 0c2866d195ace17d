// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"

#include <memory>

namespace ndg {

/// A displacement field on a regular grid (trilinear in each cell, cells only where `support` has points), so that
/// whatever lies together moves together. It minimises
///   sum_i w_i |u(x_i) - d_i|^2  +  s sum_edges |u_a - u_b|^2  +  b sum |u_a - 2 u_b + u_c|^2,
/// edges and straight triples of grid nodes; the weights of the points in a cell are first divided by their number, so
/// that densely sampled parts do not outweigh others. Deterministic.
class DisplacementField {
public:
    struct Smoothness {
        double stretch = 0.02;  ///< s
        double bend = 0.1;      ///< b
    };

    /// `support` N x 3: where the field will be asked for; `displacements` and `weights` belong to its rows (weight
    /// zero: only support). `spacing` of the grid in metres. Throws SolverError when the system is singular.
    DisplacementField(const Eigen::Ref<const Points>& support, const Eigen::Ref<const Points>& displacements,
                      const Eigen::Ref<const Eigen::VectorXd>& weights, double spacing, const Smoothness& smoothness);
    ~DisplacementField();
    DisplacementField(DisplacementField&&) noexcept;

    /// Displacements at points, N x 3; zero outside the cells of the support.
    Points at(const Eigen::Ref<const Points>& points) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace ndg
