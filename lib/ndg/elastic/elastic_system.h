// SPDX-License-Identifier: Apache-2.0
// Energy, forces and stiffness of an elastic body as functions of some of its vertices, the others held.
#pragma once

#include "ndg/elastic/elastic_model.h"

#include <Eigen/SparseCore>

#include <array>
#include <vector>

namespace ndg {

template <std::size_t Size>
struct LaneBlocks;

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
    /// An element of the model and its vertices' places among the unknown ones (-1: held). Block (a, b), a >= b, of its
    /// Hessian is the a (a + 1) / 2 + b th of `place`: the value index of its top left entry (-1: not stored); it is
    /// stored transposed where vertex a comes before b among the unknown ones.
    template <std::size_t Size>
    struct Part {
        int element = 0;
        std::array<int, Size> unknown{};
        std::array<int, Size> stride{};  ///< values from one column of the vertex to the next
        std::array<int, Size*(Size + 1) / 2> place{};
    };
    template <std::size_t Size>
    void find_places(Part<Size>& part) const;
    void make_pattern();
    template <std::size_t Size>
    static void scatter(const Part<Size>& part, const LaneBlocks<Size>& blocks, std::size_t lane, double* values);
    void flesh_hessian(const Points& positions, HessianKind kind, double* values) const;
    void skin_hessian(const Points& positions, HessianKind kind, double* values) const;

    const ElasticModel* model_;
    std::vector<int> vertices_;
    std::vector<Part<6>> flesh_;
    std::vector<Part<4>> skin_;
    std::vector<int> block_rows_;   ///< per unknown vertex: itself and its later neighbours, sorted
    std::vector<int> block_begin_;  ///< per unknown vertex: its first among block_rows_, and the end
};

}  // namespace ndg
