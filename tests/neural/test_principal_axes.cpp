// SPDX-License-Identifier: Apache-2.0
// Streamed principal components against an eigenvalue problem of all rows.
#include "ndg/neural/principal_axes.h"

#include "ndg/core/error.h"
#include "ndg/core/random.h"

#include <Eigen/SVD>
#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;

namespace {

/// Rows of rank `rank` whose k-th singular value falls like a power of k.
RowMatrixF rows_of_rank(int num_rows, int num_cols, int rank, double power)
{
    Random random(3, "rows");
    Eigen::MatrixXd left(num_rows, rank), right(num_cols, rank);
    for (Eigen::Index k = 0; k < left.size(); ++k) left.data()[k] = random.normal();
    for (Eigen::Index k = 0; k < right.size(); ++k) right.data()[k] = random.normal();
    for (int k = 0; k < rank; ++k) left.col(k) *= std::pow(k + 1.0, -power);
    return (left * right.transpose()).cast<float>();
}

RowSource source_of(const RowMatrixF& rows)
{
    RowSource source;
    source.num_rows = static_cast<int>(rows.rows());
    source.num_cols = rows.cols();
    source.row = [&rows](int i, float* values) { Eigen::Map<Eigen::RowVectorXf>(values, rows.cols()) = rows.row(i); };
    return source;
}

}  // namespace

TEST_CASE("streamed axes are the right singular vectors, with their shares")
{
    for (const auto& [num_rows, max_axes] : {std::pair(30, 50), std::pair(300, 12)}) {
        CAPTURE(num_rows);
        const RowMatrixF rows = rows_of_rank(num_rows, 5000, 60, 1.0);
        const PrincipalAxes found = principal_axes(source_of(rows), max_axes, 1.0, 5);
        const Eigen::MatrixXd all = rows.cast<double>();
        const Eigen::BDCSVD<Eigen::MatrixXd> svd(all, Eigen::ComputeThinV);
        const Eigen::Index count = std::min<Eigen::Index>(num_rows, max_axes);
        REQUIRE(found.axes.rows() == count);
        const Eigen::MatrixXd axes = found.axes.cast<double>();
        CHECK((axes * axes.transpose() - Eigen::MatrixXd::Identity(count, count)).norm() < 1e-4);
        for (Eigen::Index k = 0; k < count; ++k)
            CHECK(found.root_means[k] == Approx(svd.singularValues()[k] / std::sqrt(num_rows)).epsilon(1e-3));
        const double best = svd.singularValues().head(count).squaredNorm() / svd.singularValues().squaredNorm();
        CHECK(found.explained == Approx(best).epsilon(1e-4));
        const double kept = (all * axes.transpose()).squaredNorm() / all.squaredNorm();
        CHECK(kept == Approx(best).epsilon(1e-4));
        CHECK(std::abs(axes.row(0).dot(svd.matrixV().col(0))) > 0.999);
    }
}

TEST_CASE("no more axes than the rows have or the share needs")
{
    const RowMatrixF rows = rows_of_rank(100, 800, 7, 0.5);
    CHECK(principal_axes(source_of(rows), 40, 1.0, 1).axes.rows() == 7);
    const PrincipalAxes half = principal_axes(source_of(rows), 40, 0.6, 1);
    CHECK(half.explained >= 0.6);
    CHECK(half.axes.rows() < 7);
    // Rows that repeat, of fewer columns than axes are asked for.
    RowMatrixF repeated(12, 5);
    for (int i = 0; i < 12; ++i) repeated.row(i) << float(i % 3), 1, float(i % 3), -2, 0;
    const PrincipalAxes two = principal_axes(source_of(repeated), 5, 1.0, 1);
    CHECK(two.axes.rows() == 2);
    CHECK(two.explained == Approx(1).margin(1e-6));
    const RowMatrixF zero = RowMatrixF::Zero(4, 10);
    CHECK_THROWS_AS(principal_axes(source_of(zero), 3, 1.0, 1), InputError);
}

TEST_CASE("the same seed gives the same axes")
{
    const RowMatrixF rows = rows_of_rank(200, 600, 50, 0.3);
    const RowMatrixF first = principal_axes(source_of(rows), 10, 1.0, 1).axes;
    CHECK(first == principal_axes(source_of(rows), 10, 1.0, 1).axes);
    CHECK((first - principal_axes(source_of(rows), 10, 1.0, 2).axes).norm() > 0);
}

TEST_CASE("axes of blocks are those of their columns alone")
{
    const RowMatrixF rows = rows_of_rank(90, 400, 60, 0.5);
    std::vector<std::vector<int>> blocks(2);
    for (int k = 0; k < 400; ++k) blocks[k % 3 == 0 ? 0 : 1].push_back(k);
    const std::vector<PrincipalAxes> found = principal_axes(source_of(rows), blocks, 10, 1.0, 5);
    REQUIRE(found.size() == 2);
    for (int b = 0; b < 2; ++b) {
        RowMatrixF own(rows.rows(), static_cast<Eigen::Index>(blocks[b].size()));
        for (Eigen::Index k = 0; k < own.cols(); ++k) own.col(k) = rows.col(blocks[b][k]);
        const PrincipalAxes alone = principal_axes(source_of(own), 10, 1.0, 5);
        CHECK((found[b].axes - alone.axes).norm() < 1e-4);
        CHECK((found[b].root_means - alone.root_means).norm() < 1e-4 * alone.root_means.norm());
        CHECK(found[b].explained == Approx(alone.explained));
    }
}
