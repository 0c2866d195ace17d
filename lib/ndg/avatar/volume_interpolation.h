// SPDX-License-Identifier: Apache-2.0
// Values given at some vertices of tetrahedra, carried to the others by the cotangent Laplacian (Romero et al. 2020,
// equation 2).
#pragma once

#include "ndg/core/types.h"

#include <Eigen/SparseCore>

#include <memory>
#include <vector>

namespace ndg {

/// Cotangent stiffness matrix of tetrahedra, M x M, symmetric positive semi-definite: entry (a, b) is the integral of
/// grad phi_a . grad phi_b over the volume, which is -1/6 of the sum of length times cotangent of the edges opposite to
/// ab. Throws Error for a tetrahedron without volume.
Eigen::SparseMatrix<double> tetrahedral_laplacian(const Eigen::Ref<const Points>& vertices,
                                                  const Eigen::Ref<const Tetrahedra>& tetrahedra);

/// Factors once for one set of given vertices. Boundary vertices that are not given have no flux (natural boundary
/// conditions): constants are reproduced, linear functions too where the whole boundary is given.
class VolumeInterpolation {
public:
    /// `is_given`: M, not all false. Throws SolverError where a vertex is connected to no given one.
    VolumeInterpolation(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Tetrahedra>& tetrahedra,
                        const std::vector<bool>& is_given);
    ~VolumeInterpolation();

    /// `values`: M x k, of which the given rows are read and kept; returns all M x k.
    RowMatrix interpolate(const Eigen::Ref<const RowMatrix>& values) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace ndg
