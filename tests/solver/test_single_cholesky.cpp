// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/solver/single_cholesky.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include <limits>

using namespace ndg;
using SparseMatrix = Eigen::SparseMatrix<double>;

namespace {

/// Stiffness of a grid of springs, 3 unknowns a node, every spring with its own direction; the rim is held.
SparseMatrix spring_grid(int size, double scale)
{
    Random random(7, "springs");
    std::vector<Eigen::Triplet<double>> entries;
    const auto add = [&](int node, int other) {
        Eigen::Vector3d direction;
        for (int c = 0; c < 3; ++c) direction[c] = random.uniform(-1, 1);
        const Eigen::Matrix3d block = scale * (direction * direction.transpose() + 0.1 * Eigen::Matrix3d::Identity());
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
                entries.emplace_back(3 * node + i, 3 * node + j, block(i, j));
                if (other < 0) continue;
                entries.emplace_back(3 * other + i, 3 * other + j, block(i, j));
                entries.emplace_back(3 * node + i, 3 * other + j, -block(i, j));
                entries.emplace_back(3 * other + i, 3 * node + j, -block(i, j));
            }
        }
    };
    for (int row = 0; row < size; ++row) {
        for (int column = 0; column < size; ++column) {
            add(row * size + column, column + 1 < size ? row * size + column + 1 : -1);
            add(row * size + column, row + 1 < size ? (row + 1) * size + column : -1);
        }
    }
    SparseMatrix matrix(3 * size * size, 3 * size * size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

}  // namespace

TEST_CASE("single Cholesky solves to single precision, repeatedly, from either kind of storage")
{
    constexpr int size = 25;
    const bool lower_only = GENERATE(true, false);
    const auto stored = [&](double scale) -> SparseMatrix {
        const SparseMatrix full = spring_grid(size, scale);
        return lower_only ? SparseMatrix(full.triangularView<Eigen::Lower>()) : full;
    };
    SingleCholesky solver;
    solver.analyze(stored(1));
    Random random(8, "right-hand side");
    Eigen::VectorXd solution;
    for (const double scale : {1.0, 1e9, 1e-9}) {
        const Eigen::MatrixXd dense(spring_grid(size, scale));
        Eigen::VectorXd right(dense.rows());
        for (double& value : right) value = random.uniform(-1, 1);
        REQUIRE(solver.factorize(stored(scale)));
        solver.solve(right, solution);
        const Eigen::VectorXd expected = dense.ldlt().solve(right);
        CHECK((solution - expected).norm() < 1e-4 * expected.norm());
        CHECK((solution - expected).norm() > 0);
    }
    CHECK(solver.factor_nonzeros() > 3 * size * size);
}

TEST_CASE("single Cholesky refuses what it cannot factorise")
{
    SingleCholesky solver;
    const SparseMatrix matrix = spring_grid(6, 1);
    solver.analyze(matrix);
    Eigen::VectorXd solution;
    CHECK_THROWS_AS(solver.solve(Eigen::VectorXd::Ones(matrix.rows()), solution), SolverError);
    REQUIRE(solver.factorize(matrix));

    SparseMatrix indefinite = matrix;
    indefinite.diagonal() *= 0.3;
    CHECK_FALSE(solver.factorize(indefinite));
    CHECK_THROWS_AS(solver.solve(Eigen::VectorXd::Ones(matrix.rows()), solution), SolverError);
    indefinite.diagonal() *= -1;
    CHECK_FALSE(solver.factorize(indefinite));

    SparseMatrix broken = matrix;
    broken.coeffRef(4, 4) = std::numeric_limits<double>::quiet_NaN();
    CHECK_THROWS_AS(solver.factorize(broken), SolverError);
    broken = matrix;
    broken.coeffRef(4, 3) = std::numeric_limits<double>::infinity();
    CHECK_THROWS_AS(solver.factorize(broken), SolverError);
    CHECK_THROWS_AS(solver.factorize(spring_grid(5, 1)), SolverError);

    REQUIRE(solver.factorize(matrix));
    CHECK_THROWS_AS(solver.solve(Eigen::VectorXd::Ones(3), solution), SolverError);
    SparseMatrix hollow(2, 2);
    hollow.insert(1, 0) = 1;
    hollow.makeCompressed();
    CHECK_THROWS_AS(solver.analyze(hollow), SolverError);
    CHECK_THROWS_AS(solver.analyze(SparseMatrix(2, 3)), SolverError);
}
