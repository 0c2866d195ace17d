// SPDX-License-Identifier: Apache-2.0
// Co-rotated linear elasticity (NDG 5.2.2, equations 22 and 23; Capell et al. 2005) as a way to pose the flesh.
#pragma once

#include "ndg/deform/deformer.h"
#include "ndg/elastic/corotated_term.h"
#include "ndg/elastic/objective.h"
#include "ndg/solver/sparse_cholesky.h"

namespace ndg {

/// The minimum of the energy of corotated_term.h, the bone wrap given. R_v: blended quaternions of the up to eight
/// bones that skin the vertex; moduli and Poisson's ratio those of the simulation's defaults (NDG 3.2). The matrix
/// turns with the rotations: a frame costs its assembly, a factorisation and one solve; the symbolic analysis is made
/// once.
class CorotatedElasticity : public Deformer {
public:
    /// Keeps a reference to `body_template`.
    explicit CorotatedElasticity(const Template& body_template);

    /// Throws SolverError when the system is not positive definite.
    Points deform(const PosedBody& posed) override;

private:
    SkinningWeights volume_weights_;
    ElasticBody body_;
    CorotatedTerm* term_;  ///< of body_
    Objective objective_;
    Eigen::SparseMatrix<double> stiffness_;
    SparseCholesky cholesky_;
    const Body* rest_ = nullptr;
};

/// "corotated".
void register_corotated_elasticity(MethodTable& table);

}  // namespace ndg
