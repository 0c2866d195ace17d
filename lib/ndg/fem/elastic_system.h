// SPDX-License-Identifier: Apache-2.0
// Energy, forces and stiffness of an elastic body as functions of some of its vertices, the others held.
#pragma once

#include "ndg/fem/elastic_model.h"

#include <Eigen/SparseCore>

#include <array>
#include <vector>

namespace ndg {

/// How an element's Hessian enters the sum.
enum class HessianKind {
    exact,
    nearly_exact,  ///< made positive semi-definite where its smallest eigenvalue is far below zero
    projected,     ///< made positive semi-definite (Teran et al. 2005)
    gauss_newton,  ///< the same for flesh; hinges with the stiffness of their angle alone
};

/// Unknowns, sparsity pattern and the places of every element's entries in it; made once per template for the whole
/// body, or for a part of it. Positions are always those of all volume vertices, N_v x 3; unknown 3 i + c is coordinate
/// c of vertex vertices()[i]. Functions are const and do not allocate in element loops; matrix and vectors are the
/// caller's, one a thread.
class ElasticSystem {
public:
    /// All of muscle wrap and skin is unknown. Keeps a reference to `model`, whose rest shape may change.
    explicit ElasticSystem(const ElasticModel& model);
    /// The given vertices are unknown, ascending, none of the bone wrap.
    ElasticSystem(const ElasticModel& model, std::vector<int> vertices);

    const ElasticModel& model() const { return *model_; }
    const std::vector<int>& vertices() const { return vertices_; }
    int num_unknowns() const { return 3 * static_cast<int>(vertices_.size()); }

    /// Joule, of the elements that have an unknown vertex; zero at rest and under rigid motions.
    double energy(const Points& positions) const;

    /// d energy / d unknowns in newton, and per unknown the sum over elements of the absolute force each contributes
    /// there: against its norm the norm of the gradient is the share of the forces out of balance.
    void gradient(const Points& positions, Eigen::VectorXd& gradient, Eigen::VectorXd& absolute) const;

    /// A matrix of the Hessian's pattern, zero: lower triangle in 3 x 3 vertex blocks, diagonal blocks full.
    Eigen::SparseMatrix<double> hessian_pattern() const;
    /// d^2 energy / d unknowns^2, or an approximation, into a matrix made by hessian_pattern().
    void hessian(const Points& positions, HessianKind kind, Eigen::SparseMatrix<double>& hessian) const;

private:
    /// An element of the model, its vertices' places among the unknown ones (-1: held), and the value index of the top
    /// left entry of block (row vertex a, column vertex b) at [a + Size b] (-1: not stored).
    template <std::size_t Size>
    struct Part {
        int element = 0;
        std::array<int, Size> unknown{};
        std::array<int, Size * Size> place{};
    };
    template <std::size_t Size>
    void find_places(Part<Size>& part) const;
    void make_pattern();

    const ElasticModel* model_;
    std::vector<int> vertices_;
    std::vector<Part<6>> flesh_;
    std::vector<Part<4>> skin_;
    std::vector<std::vector<int>> block_rows_;  ///< per unknown vertex: itself and its later neighbours, sorted
    std::vector<int> block_begin_;              ///< per unknown vertex: value index of its first column
    int num_values_ = 0;
};

}  // namespace ndg
