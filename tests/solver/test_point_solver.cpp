// SPDX-License-Identifier: Apache-2.0
#include "ndg/solver/point_solver.h"

#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/core/threads.h"
#include "ndg/solver/sparse_cholesky.h"

#include <catch2/catch.hpp>

#include <limits>
#include <vector>

using namespace ndg;

namespace {

/// A grid of springs, each unknown also held by a spring of its own: the full matrix.
Eigen::SparseMatrix<double> grid(int width, int height, double held, std::uint64_t seed)
{
    Random random(seed, "grid");
    std::vector<Eigen::Triplet<double>> entries;
    const auto connect = [&](int a, int b) {
        const double stiffness = random.uniform(0.5, 2.0);
        entries.emplace_back(a, a, stiffness);
        entries.emplace_back(b, b, stiffness);
        entries.emplace_back(a, b, -stiffness);
        entries.emplace_back(b, a, -stiffness);
    };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const int v = y * width + x;
            entries.emplace_back(v, v, held);
            if (x + 1 < width) connect(v, v + 1);
            if (y + 1 < height) connect(v, v + width);
        }
    Eigen::SparseMatrix<double> matrix(width * height, width * height);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

Eigen::Matrix4Xf random_points(Eigen::Index count)
{
    Random random(9, "points");
    Eigen::Matrix4Xf points(4, count);
    for (Eigen::Index i = 0; i < points.size(); ++i) points.data()[i] = static_cast<float>(random.normal());
    return points;
}

double largest_error(PointSolver& solver, const Eigen::SparseMatrix<double>& matrix)
{
    const Eigen::Matrix4Xf right_hand_side = random_points(matrix.rows());
    SparseCholesky exact;
    exact.analyze(matrix);
    REQUIRE(exact.factorize(matrix));
    const Eigen::MatrixXd expected = exact.solve(right_hand_side.topRows(3).transpose().cast<double>());
    Eigen::Matrix4Xf points = right_hand_side;
    solver.solve(points);
    CHECK(points.row(3) == right_hand_side.row(3));
    return (points.topRows(3).transpose().cast<double>() - expected).cwiseAbs().maxCoeff() /
           expected.cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("Points are those of a solve in double, to single precision")
{
    for (const auto& [width, height] : {std::pair(1, 1), std::pair(7, 1), std::pair(40, 33), std::pair(150, 90)}) {
        INFO(width << " x " << height);
        const Eigen::SparseMatrix<double> matrix = grid(width, height, 0.01, 1);
        PointSolver solver;
        solver.analyze(matrix);
        solver.factorize(matrix);
        CHECK(solver.num_unknowns() == width * height);
        CHECK(largest_error(solver, matrix) < 1e-5);
    }
}

TEST_CASE("A matrix of several parts that are not connected is solved, and another one of its pattern after it")
{
    const Eigen::SparseMatrix<double> one = grid(30, 20, 0.1, 2);
    std::vector<Eigen::Triplet<double>> entries;
    for (int copy = 0; copy < 3; ++copy)
        for (int column = 0; column < one.outerSize(); ++column)
            for (Eigen::SparseMatrix<double>::InnerIterator it(one, column); it; ++it)
                entries.emplace_back(600 * copy + int(it.row()), 600 * copy + column, (1.0 + copy) * it.value());
    Eigen::SparseMatrix<double> matrix(1800, 1800);
    matrix.setFromTriplets(entries.begin(), entries.end());
    PointSolver solver;
    solver.analyze(matrix);
    solver.factorize(matrix);
    CHECK(largest_error(solver, matrix) < 1e-5);
    matrix *= 3.0;
    solver.factorize(matrix);
    CHECK(largest_error(solver, matrix) < 1e-5);
}

TEST_CASE("Points do not depend on the number of threads")
{
    const Eigen::SparseMatrix<double> matrix = grid(80, 80, 0.01, 3);
    PointSolver solver;
    solver.analyze(matrix);
    solver.factorize(matrix);
    Eigen::Matrix4Xf alone = random_points(matrix.rows()), together = alone;
    set_num_threads(1);
    solver.solve(alone);
    set_num_threads(3);
    solver.solve(together);
    set_num_threads(0);
    CHECK(alone == together);
}

TEST_CASE("What cannot be factored or solved is refused")
{
    Eigen::SparseMatrix<double> matrix = grid(10, 10, 0.01, 4);
    PointSolver solver;
    Eigen::Matrix4Xf points = random_points(100);
    CHECK_THROWS_AS(solver.solve(points), SolverError);
    CHECK_THROWS_AS(solver.factorize(matrix), SolverError);
    solver.analyze(matrix);
    CHECK_THROWS_AS(solver.factorize(grid(10, 9, 0.01, 4)), SolverError);
    CHECK_THROWS_AS(solver.factorize(-1.0 * matrix), SolverError);
    matrix.valuePtr()[5] = std::numeric_limits<double>::quiet_NaN();
    CHECK_THROWS_AS(solver.factorize(matrix), SolverError);
}
