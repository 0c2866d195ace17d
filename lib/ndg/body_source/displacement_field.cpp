// SPDX-License-Identifier: Apache-2.0
#include "ndg/body_source/displacement_field.h"

#include "ndg/core/error.h"
#include "ndg/solver/sparse_cholesky.h"

#include <Eigen/SparseCore>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace ndg {
namespace {

using Cell = std::array<int, 3>;
using Corners = Eigen::Matrix<double, 8, 1>;
/// Holds nodes that no point reaches, relative to a point's weight of one.
constexpr double hold = 1e-6;

Cell cell_of(const Eigen::RowVector3d& point, double spacing)
{
    return {int(std::floor(point[0] / spacing)), int(std::floor(point[1] / spacing)),
            int(std::floor(point[2] / spacing))};
}

Cell corner_of(const Cell& cell, int corner)
{
    return {cell[0] + (corner & 1), cell[1] + ((corner >> 1) & 1), cell[2] + ((corner >> 2) & 1)};
}

/// A point's shares of the eight corners of its cell.
Corners corner_shares(const Eigen::RowVector3d& point, const Cell& cell, double spacing)
{
    Corners shares;
    for (int c = 0; c < 8; ++c) {
        shares[c] = 1.0;
        for (int k = 0; k < 3; ++k) {
            const double t = point[k] / spacing - cell[std::size_t(k)];
            shares[c] *= (c >> k) & 1 ? t : 1.0 - t;
        }
    }
    return shares;
}

void sort_unique(std::vector<Cell>& cells)
{
    std::sort(cells.begin(), cells.end());
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
}

/// Index in a sorted list, -1 for none.
int find(const std::vector<Cell>& sorted, const Cell& cell)
{
    const auto found = std::lower_bound(sorted.begin(), sorted.end(), cell);
    return found == sorted.end() || *found != cell ? -1 : int(found - sorted.begin());
}

using Triplets = std::vector<Eigen::Triplet<double>>;

void add_smoothness(const std::vector<Cell>& nodes, const DisplacementField::Smoothness& smoothness, Triplets& entries)
{
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const int a = int(i);
        entries.emplace_back(a, a, hold);
        for (std::size_t k = 0; k < 3; ++k) {
            Cell step = nodes[i];
            step[k] += 1;
            const int b = find(nodes, step);
            if (b < 0) continue;
            entries.emplace_back(a, a, smoothness.stretch);
            entries.emplace_back(b, b, smoothness.stretch);
            entries.emplace_back(a, b, -smoothness.stretch);
            entries.emplace_back(b, a, -smoothness.stretch);
            step[k] += 1;
            const int c = find(nodes, step);
            if (c < 0) continue;
            const std::array<int, 3> triple = {a, b, c};
            const std::array<double, 3> second = {1, -2, 1};
            for (std::size_t p = 0; p < 3; ++p)
                for (std::size_t q = 0; q < 3; ++q)
                    entries.emplace_back(triple[p], triple[q], smoothness.bend * second[p] * second[q]);
        }
    }
}

}  // namespace

struct DisplacementField::State {
    double spacing = 0;
    std::vector<Cell> cells;
    std::vector<std::array<int, 8>> corners;  // node of each corner of each cell
    Eigen::MatrixXd values;                   // nodes x 3
};

DisplacementField::DisplacementField(const Eigen::Ref<const Points>& support,
                                     const Eigen::Ref<const Points>& displacements,
                                     const Eigen::Ref<const Eigen::VectorXd>& weights, double spacing,
                                     const Smoothness& smoothness)
    : state_(std::make_unique<State>())
{
    require(spacing > 0.0 && displacements.rows() == support.rows() && weights.size() == support.rows(),
            "a displacement field of spacing {} was given {} points, {} displacements and {} weights", spacing,
            support.rows(), displacements.rows(), weights.size());
    state_->spacing = spacing;
    std::vector<Cell>& cells = state_->cells;
    for (Eigen::Index i = 0; i < support.rows(); ++i) cells.push_back(cell_of(support.row(i), spacing));
    const std::vector<Cell> cell_of_point = cells;
    sort_unique(cells);
    std::vector<Cell> nodes;
    for (const Cell& cell : cells)
        for (int c = 0; c < 8; ++c) nodes.push_back(corner_of(cell, c));
    sort_unique(nodes);
    state_->corners.resize(cells.size());
    for (std::size_t i = 0; i < cells.size(); ++i)
        for (int c = 0; c < 8; ++c) state_->corners[i][std::size_t(c)] = find(nodes, corner_of(cells[i], c));

    // What the points of a cell ask for is one small block each.
    struct Block {
        Eigen::Matrix<double, 8, 8> matrix = Eigen::Matrix<double, 8, 8>::Zero();
        Eigen::Matrix<double, 8, 3> right = Eigen::Matrix<double, 8, 3>::Zero();
        double count = 0;
    };
    std::vector<Block> blocks(cells.size());
    for (Eigen::Index i = 0; i < support.rows(); ++i) {
        if (!(weights[i] > 0.0)) continue;
        const Cell& cell = cell_of_point[std::size_t(i)];
        const Corners shares = corner_shares(support.row(i), cell, spacing);
        Block& block = blocks[std::size_t(find(cells, cell))];
        block.matrix += weights[i] * shares * shares.transpose();
        block.right += weights[i] * shares * displacements.row(i);
        block.count += 1.0;
    }
    Triplets entries;
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(Eigen::Index(nodes.size()), 3);
    for (std::size_t i = 0; i < cells.size(); ++i) {
        if (blocks[i].count == 0) continue;
        const std::array<int, 8>& index = state_->corners[i];
        for (int a = 0; a < 8; ++a) {
            right.row(index[std::size_t(a)]) += blocks[i].right.row(a) / blocks[i].count;
            for (int b = 0; b < 8; ++b)
                entries.emplace_back(index[std::size_t(a)], index[std::size_t(b)],
                                     blocks[i].matrix(a, b) / blocks[i].count);
        }
    }
    add_smoothness(nodes, smoothness, entries);
    Eigen::SparseMatrix<double> matrix(Eigen::Index(nodes.size()), Eigen::Index(nodes.size()));
    matrix.setFromTriplets(entries.begin(), entries.end());
    SparseCholesky solver;
    solver.analyze(matrix);
    if (!solver.factorize(matrix)) throw SolverError("the displacement field's system is not positive definite");
    state_->values = solver.solve(right);
}

DisplacementField::~DisplacementField() = default;
DisplacementField::DisplacementField(DisplacementField&&) noexcept = default;

Points DisplacementField::at(const Eigen::Ref<const Points>& points) const
{
    Points result = Points::Zero(points.rows(), 3);
#pragma omp parallel for schedule(static)
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        const Cell cell = cell_of(points.row(i), state_->spacing);
        const int found = find(state_->cells, cell);
        if (found < 0) continue;
        const Corners shares = corner_shares(points.row(i), cell, state_->spacing);
        const std::array<int, 8>& index = state_->corners[std::size_t(found)];
        for (std::size_t c = 0; c < 8; ++c) result.row(i) += shares[Eigen::Index(c)] * state_->values.row(index[c]);
    }
    return result;
}

}  // namespace ndg
