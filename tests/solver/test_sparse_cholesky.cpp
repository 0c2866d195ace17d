// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/solver/sparse_cholesky.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

using namespace ndg;
using Method = SparseCholesky::Method;
using SparseMatrix = Eigen::SparseMatrix<double>;

namespace {

/// Random symmetric, diagonally dominant matrix with both triangles stored; `scale` varies the values, not the pattern.
SparseMatrix random_spd(int size, double scale = 1.0)
{
    Random random(51, "spd");
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd diagonal = Eigen::VectorXd::Constant(size, 0.5);
    for (int k = 0; k < 4 * size; ++k) {
        const int i = static_cast<int>(random.below(static_cast<std::uint64_t>(size)));
        const int j = static_cast<int>(random.below(static_cast<std::uint64_t>(size)));
        const double value = scale * random.uniform(-1, 1);
        if (i == j) continue;
        entries.emplace_back(i, j, value);
        entries.emplace_back(j, i, value);
        diagonal[i] += std::abs(value);
        diagonal[j] += std::abs(value);
    }
    for (int i = 0; i < size; ++i) entries.emplace_back(i, i, diagonal[i]);
    SparseMatrix matrix(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

Eigen::MatrixXd random_matrix(int rows, int columns)
{
    Random random(52, "rhs");
    Eigen::MatrixXd matrix(rows, columns);
    for (Eigen::Index i = 0; i < matrix.size(); ++i) matrix.data()[i] = random.uniform(-1, 1);
    return matrix;
}

}  // namespace

TEST_CASE("sparse Cholesky agrees with a dense solver, repeatedly")
{
    const auto method = GENERATE(Method::automatic, Method::simplicial, Method::supernodal);
    constexpr int size = 150;
    SparseCholesky solver(method);
    solver.analyze(random_spd(size));
    for (const double scale : {1.0, 3.0, 0.2}) {
        const SparseMatrix matrix = random_spd(size, scale);
        REQUIRE(solver.factorize(matrix));
        for (const int columns : {1, 3, 7}) {
            const Eigen::MatrixXd right = random_matrix(size, columns);
            const Eigen::MatrixXd expected = Eigen::MatrixXd(matrix).ldlt().solve(right);
            CHECK((solver.solve(right) - expected).norm() < 1e-11 * expected.norm());
        }
    }
    CHECK(solver.factor_nonzeros() >= size);
    CHECK(solver.factor_nonzeros() <= 0.5 * size * (size + 1));
}

TEST_CASE("sparse Cholesky reads the lower triangle only")
{
    constexpr int size = 40;
    const SparseMatrix full = random_spd(size);
    const SparseMatrix lower = full.triangularView<Eigen::Lower>();
    SparseMatrix garbled = full;
    for (int column = 0; column < size; ++column) {
        for (SparseMatrix::InnerIterator entry(garbled, column); entry; ++entry) {
            if (entry.row() < column) entry.valueRef() = std::numeric_limits<double>::quiet_NaN();
        }
    }
    const Eigen::MatrixXd right = random_matrix(size, 2);
    SparseCholesky from_full;
    from_full.analyze(full);
    REQUIRE(from_full.factorize(full));
    const Eigen::MatrixXd expected = from_full.solve(right);
    REQUIRE(from_full.factorize(garbled));
    CHECK(from_full.solve(right) == expected);
    SparseCholesky from_lower;
    from_lower.analyze(lower);
    REQUIRE(from_lower.factorize(lower));
    CHECK(from_lower.solve(right) == expected);
}

TEST_CASE("sparse Cholesky counts the factor of a tridiagonal matrix")
{
    constexpr int size = 20;
    std::vector<Eigen::Triplet<double>> entries;
    for (int i = 0; i < size; ++i) {
        entries.emplace_back(i, i, 2.5);
        if (i > 0) entries.emplace_back(i, i - 1, -1.0);
    }
    SparseMatrix matrix(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    SparseCholesky solver(Method::simplicial);
    solver.analyze(matrix);
    REQUIRE(solver.factorize(matrix));
    CHECK(solver.factor_nonzeros() == 2 * size - 1);
}

TEST_CASE("sparse Cholesky says when a matrix is not positive definite and goes on")
{
    const auto method = GENERATE(Method::automatic, Method::simplicial, Method::supernodal);
    constexpr int size = 60;
    const SparseMatrix good = random_spd(size);
    SparseMatrix indefinite = good;
    indefinite.coeffRef(31, 31) = -1.0;
    SparseMatrix zero = good;
    zero.coeffs().setZero();
    SparseCholesky solver(method);
    solver.analyze(good);
    const Eigen::MatrixXd right = random_matrix(size, 1);
    REQUIRE(solver.factorize(good));
    const Eigen::MatrixXd expected = solver.solve(right);
    CHECK_FALSE(solver.factorize(indefinite));
    CHECK_THROWS_AS(solver.solve(right), SolverError);
    CHECK_FALSE(solver.factorize(zero));
    REQUIRE(solver.factorize(good));
    CHECK(solver.solve(right) == expected);
}

TEST_CASE("sparse Cholesky rejects what it cannot solve")
{
    constexpr int size = 30;
    const SparseMatrix matrix = random_spd(size);
    SparseCholesky solver;
    CHECK_THROWS_AS(solver.factorize(matrix), SolverError);
    CHECK_THROWS_AS(solver.solve(random_matrix(size, 1)), SolverError);
    CHECK_THROWS_AS(solver.analyze(SparseMatrix(3, 4)), SolverError);
    SparseMatrix loose = matrix;
    loose.uncompress();
    CHECK_THROWS_AS(solver.analyze(loose), SolverError);

    solver.analyze(matrix);
    SparseMatrix other = matrix;
    other.prune([](int row, int column, double) { return !(row == 29 && column == 29); });
    other.makeCompressed();
    CHECK_THROWS_AS(solver.factorize(other), SolverError);
    CHECK_THROWS_AS(solver.factorize(random_spd(size + 1)), SolverError);
    SparseMatrix infinite = matrix;
    infinite.coeffRef(5, 5) = std::numeric_limits<double>::infinity();
    CHECK_THROWS_AS(solver.factorize(infinite), SolverError);
    CHECK_THROWS_AS(solver.solve(random_matrix(size, 1)), SolverError);

    REQUIRE(solver.factorize(matrix));
    CHECK_THROWS_AS(solver.solve(random_matrix(size + 1, 1)), SolverError);
    Eigen::MatrixXd right = random_matrix(size, 2);
    right(3, 1) = std::numeric_limits<double>::quiet_NaN();
    CHECK_THROWS_AS(solver.solve(right), SolverError);
}

TEST_CASE("sparse Cholesky solves parts of a larger array, moves, and changes its pattern")
{
    const SparseMatrix matrix = random_spd(25);
    SparseCholesky first;
    first.analyze(matrix);
    REQUIRE(first.factorize(matrix));
    const Eigen::MatrixXd large = random_matrix(40, 5);
    const Eigen::MatrixXd expected = Eigen::MatrixXd(matrix).ldlt().solve(large.block(3, 1, 25, 3));
    CHECK((first.solve(large.block(3, 1, 25, 3)) - expected).norm() < 1e-12 * expected.norm());
    SparseCholesky second = std::move(first);
    CHECK((second.solve(large.block(3, 1, 25, 3)) - expected).norm() < 1e-12 * expected.norm());
    const SparseMatrix bigger = random_spd(40);
    second.analyze(bigger);
    CHECK_THROWS_AS(second.solve(large), SolverError);
    REQUIRE(second.factorize(bigger));
    CHECK((bigger * second.solve(large) - large).norm() < 1e-12);
}
