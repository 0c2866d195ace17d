// SPDX-License-Identifier: Apache-2.0
#include "ndg/solver/dense_panels.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include <vector>

using namespace ndg;

namespace {

std::vector<float> padded(const Eigen::MatrixXf& matrix)
{
    std::vector<float> values(matrix.data(), matrix.data() + matrix.size());
    values.resize(values.size() + dense_panel_padding);
    return values;
}

Eigen::MatrixXf unpadded(const std::vector<float>& values, Eigen::Index rows, Eigen::Index columns)
{
    return Eigen::Map<const Eigen::MatrixXf>(values.data(), rows, columns);
}

}  // namespace

TEST_CASE("A panel's factor, and what it leaves to the rows below, are those of Eigen", "[solver][dense_panels]")
{
    std::srand(5);
    for (const int columns : {1, 2, 3, 5, 6, 7, 12, 18, 31}) {
        for (const int below : {0, 1, 7, 8, 15, 16, 40}) {
            const int rows = columns + below;
            const Eigen::MatrixXf random = Eigen::MatrixXf::Random(columns, columns);
            Eigen::MatrixXf block = Eigen::MatrixXf::Random(rows, columns);
            block.topRows(columns) = random * random.transpose() + Eigen::MatrixXf::Identity(columns, columns);
            std::vector<float> values = padded(block);
            REQUIRE(factorize_panel(values.data(), columns, rows));
            const Eigen::MatrixXf factor = unpadded(values, rows, columns);
            const Eigen::LLT<Eigen::MatrixXd> expected(block.topRows(columns).cast<double>());
            const Eigen::MatrixXd lower = expected.matrixL();
            CAPTURE(columns, below);
            const Eigen::MatrixXd found =
                factor.topRows(columns).triangularView<Eigen::Lower>().toDenseMatrix().cast<double>();
            REQUIRE((found - lower).norm() < 1e-5 * lower.norm() * columns);
            const Eigen::MatrixXd product = factor.bottomRows(below).cast<double>() * lower.transpose();
            REQUIRE((product - block.bottomRows(below).cast<double>()).norm() < 1e-4 * (1 + block.norm()));

            // Both substitutions against the same factor with the rows below.
            const Eigen::VectorXf right = Eigen::VectorXf::Random(rows);
            Eigen::VectorXf x = right;
            substitute_forward(values.data(), columns, rows, x.data());
            Eigen::VectorXd expected_x = right.cast<double>();
            lower.triangularView<Eigen::Lower>().solveInPlace(expected_x.head(columns));
            const Eigen::MatrixXd rest = factor.bottomRows(below).cast<double>();
            expected_x.tail(below) -= rest * expected_x.head(columns);
            REQUIRE((x.cast<double>() - expected_x).norm() < 1e-4 * (1 + expected_x.norm()));
            x = right;
            substitute_backward(values.data(), columns, rows, x.data());
            expected_x = right.cast<double>();
            expected_x.head(columns) -= rest.transpose() * expected_x.tail(below);
            lower.transpose().triangularView<Eigen::Upper>().solveInPlace(expected_x.head(columns));
            REQUIRE((x.cast<double>() - expected_x).norm() < 1e-4 * (1 + expected_x.norm()));
        }
    }
}

TEST_CASE("A panel that is not positive definite is found, wherever", "[solver][dense_panels]")
{
    for (const int bad : {0, 4, 6, 13}) {
        Eigen::MatrixXf block = Eigen::MatrixXf::Identity(20, 14);
        block(bad, bad) = -1;
        std::vector<float> values = padded(block);
        REQUIRE_FALSE(factorize_panel(values.data(), 14, 20));
    }
}

TEST_CASE("Products are subtracted on and below the target's diagonal, side by side or scattered",
          "[solver][dense_panels]")
{
    std::srand(6);
    for (const int height : {1, 5, 8, 9, 16, 33}) {
        for (const int width : {1, 2, 3, 4, 6, 9}) {
            if (width > height) continue;
            for (const int depth : {1, 3, 18}) {
                const Eigen::MatrixXf a = Eigen::MatrixXf::Random(height + 2, depth);
                const std::vector<float> source = padded(a);
                DenseUpdate update;
                update.a = source.data() + 2;
                update.stride = static_cast<std::size_t>(height + 2);
                update.depth = depth;
                update.height = height;
                update.width = width;
                const Eigen::MatrixXf expected = -a.bottomRows(height) * a.middleRows(2, width).transpose();
                const auto check = [&](const Eigen::MatrixXf& target, const std::vector<int>& place) {
                    for (int c = 0; c < width; ++c) {
                        for (int r = c; r < height; ++r) {
                            const auto row = place[r], column = place[c];
                            REQUIRE(std::abs(target(row, column) - expected(r, c)) < 1e-5F);
                        }
                    }
                };
                CAPTURE(height, width, depth);
                std::vector<int> place(height);
                for (int r = 0; r < height; ++r) place[r] = r;
                Eigen::MatrixXf target = Eigen::MatrixXf::Zero(height, width);
                subtract_contiguous(update, target.data(), static_cast<std::size_t>(height));
                check(target, place);
                for (int r = 0; r < height; ++r) place[r] = r + r / 3 + (r > 20 ? 5 : 0);
                const int rows = place.back() + 1;
                target = Eigen::MatrixXf::Zero(rows, rows);
                subtract_scattered(update, target.data(), static_cast<std::size_t>(rows), place.data());
                check(target, place);
                // Nothing outside the given rows and columns is touched.
                for (int r = 0; r < height; ++r) {
                    for (int c = 0; c < width; ++c) {
                        target(place[r], place[c]) = 0;
                    }
                }
                REQUIRE(target.norm() == 0);
            }
        }
    }
}
