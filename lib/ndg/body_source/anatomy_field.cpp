// SPDX-License-Identifier: Apache-2.0
#include "ndg/body_source/anatomy_field.h"

#include "ndg/core/error.h"
#include "ndg/solver/sparse_cholesky.h"

#include <Eigen/SparseCore>

#include <array>
#include <cmath>
#include <map>
#include <vector>

namespace ndg {
namespace {

using Cell = std::array<int, 3>;
/// Holds nodes that no point reaches, relative to a point's weight of one.
constexpr double hold = 1e-6;

Cell cell_of(const Eigen::RowVector3d& point, double spacing)
{
    return {int(std::floor(point[0] / spacing)), int(std::floor(point[1] / spacing)),
            int(std::floor(point[2] / spacing))};
}

/// The eight corners of a cell and a point's shares of them.
struct Corners {
    std::array<Cell, 8> nodes;
    std::array<double, 8> shares{};
};

Corners corners_of(const Eigen::RowVector3d& point, double spacing)
{
    const Cell cell = cell_of(point, spacing);
    Corners corners;
    for (std::size_t c = 0; c < 8; ++c) {
        double share = 1.0;
        for (std::size_t k = 0; k < 3; ++k) {
            const int bit = (c >> k) & 1u ? 1 : 0;
            const double t = point[Eigen::Index(k)] / spacing - cell[k];
            corners.nodes[c][k] = cell[k] + bit;
            share *= bit ? t : 1.0 - t;
        }
        corners.shares[c] = share;
    }
    return corners;
}

}  // namespace

struct DisplacementField::State {
    double spacing = 0;
    std::map<Cell, int> nodes;
    Eigen::MatrixXd values;  // nodes x 3
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
    std::map<Cell, int> counts;
    for (Eigen::Index i = 0; i < support.rows(); ++i) {
        int& count = counts[cell_of(support.row(i), spacing)];
        count += weights[i] > 0.0 ? 1 : 0;
    }
    std::map<Cell, int>& nodes = state_->nodes;
    for (const auto& [cell, unused] : counts)
        for (int c = 0; c < 8; ++c)
            nodes.emplace(Cell{cell[0] + (c & 1), cell[1] + ((c >> 1) & 1), cell[2] + ((c >> 2) & 1)}, 0);
    int next = 0;
    for (auto& [unused, index] : nodes) index = next++;

    const auto num_nodes = static_cast<Eigen::Index>(nodes.size());
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(num_nodes, 3);
    // One 8 x 8 block for each cell keeps the list of entries short.
    struct Block {
        Eigen::Matrix<double, 8, 8> matrix = Eigen::Matrix<double, 8, 8>::Zero();
    };
    std::map<Cell, Block> blocks;
    for (Eigen::Index i = 0; i < support.rows(); ++i) {
        if (!(weights[i] > 0.0)) continue;
        const Cell cell = cell_of(support.row(i), spacing);
        const Corners corners = corners_of(support.row(i), spacing);
        const double weight = weights[i] / counts[cell];
        Block& block = blocks[cell];
        const Eigen::Map<const Eigen::Matrix<double, 8, 1>> shares(corners.shares.data());
        block.matrix += weight * shares * shares.transpose();
        for (std::size_t c = 0; c < 8; ++c)
            right.row(nodes.at(corners.nodes[c])) += weight * corners.shares[c] * displacements.row(i);
    }
    for (const auto& [cell, block] : blocks) {
        std::array<int, 8> index{};
        for (int c = 0; c < 8; ++c)
            index[std::size_t(c)] = nodes.at({cell[0] + (c & 1), cell[1] + ((c >> 1) & 1), cell[2] + ((c >> 2) & 1)});
        for (int a = 0; a < 8; ++a)
            for (int b = 0; b < 8; ++b)
                entries.emplace_back(index[std::size_t(a)], index[std::size_t(b)], block.matrix(a, b));
    }
    for (const auto& [cell, a] : nodes) {
        entries.emplace_back(a, a, hold);
        for (std::size_t k = 0; k < 3; ++k) {
            Cell step = cell;
            step[k] += 1;
            const auto b = nodes.find(step);
            if (b == nodes.end()) continue;
            entries.emplace_back(a, a, smoothness.stretch);
            entries.emplace_back(b->second, b->second, smoothness.stretch);
            entries.emplace_back(a, b->second, -smoothness.stretch);
            entries.emplace_back(b->second, a, -smoothness.stretch);
            step[k] += 1;
            const auto c = nodes.find(step);
            if (c == nodes.end()) continue;
            const std::array<int, 3> triple = {a, b->second, c->second};
            const std::array<double, 3> second = {1, -2, 1};
            for (std::size_t i = 0; i < 3; ++i)
                for (std::size_t j = 0; j < 3; ++j)
                    entries.emplace_back(triple[i], triple[j], smoothness.bend * second[i] * second[j]);
        }
    }
    Eigen::SparseMatrix<double> matrix(num_nodes, num_nodes);
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
        const Corners corners = corners_of(points.row(i), state_->spacing);
        Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
        bool inside = true;
        for (std::size_t c = 0; c < 8 && inside; ++c) {
            const auto node = state_->nodes.find(corners.nodes[c]);
            inside = node != state_->nodes.end();
            if (inside) sum += corners.shares[c] * state_->values.row(node->second);
        }
        if (inside) result.row(i) = sum;
    }
    return result;
}

}  // namespace ndg
