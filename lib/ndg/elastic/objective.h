// SPDX-License-Identifier: Apache-2.0
// What Newton's method minimises: a body's energy as a function of some of its vertices, the others held.
#pragma once

#include "ndg/elastic/elastic_body.h"

#include <vector>

namespace ndg {

/// Unknowns, sparsity pattern and the places of every element's entries in it; made once per template for the whole
/// body, or for a part of it. Positions are always those of all vertices, N_v x 3; unknown 3 i + c is coordinate c of
/// vertex vertices()[i]. Functions are const and do not allocate in element loops; matrix and vectors are the caller's,
/// one a thread.
class Objective {
public:
    /// All vertices that may move are unknown. Keeps a reference to `body`, whose rest shape may change.
    explicit Objective(const ElasticBody& body);
    /// The given vertices are unknown, ascending, none of the fixed ones unless these too may move.
    Objective(const ElasticBody& body, std::vector<int> vertices, bool fixed_may_move = false);

    const ElasticBody& body() const { return body_; }
    const std::vector<int>& vertices() const { return vertices_; }
    int num_unknowns() const { return 3 * static_cast<int>(vertices_.size()); }

    /// Joule, of the elements that have an unknown vertex.
    double energy(const Points& positions) const;

    /// d energy / d unknowns in newton, and per unknown the sum over elements of the absolute force each contributes
    /// there: against its norm the norm of the gradient is the share of the forces out of balance.
    void gradient(const Points& positions, Eigen::VectorXd& gradient, Eigen::VectorXd& absolute) const;

    /// A matrix of the Hessian's pattern, zero: lower triangle in 3 x 3 vertex blocks, diagonal blocks full.
    Eigen::SparseMatrix<double> hessian_pattern() const { return pattern_.matrix(); }
    /// d^2 energy / d unknowns^2, or an approximation, into a matrix made by hessian_pattern().
    void hessian(const Points& positions, HessianKind kind, Eigen::SparseMatrix<double>& hessian) const;

private:
    const ElasticBody& body_;
    std::vector<int> vertices_;
    std::vector<ElementPlaces> places_;  ///< of every term
    SparsityPattern pattern_;
};

}  // namespace ndg
