// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/shape_space.h"
#include "ndg/core/error.h"
#include "ndg/core/random.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;

namespace {

/// Shapes on a hyperplane: a mean and `rank` directions of falling strength.
std::vector<Points> low_rank_shapes(int count, int rank, int num_vertices)
{
    Random random(21, "shapes");
    const auto draw = [&] {
        Points points(num_vertices, 3);
        for (Eigen::Index i = 0; i < points.size(); ++i) points.data()[i] = random.normal();
        return points;
    };
    const Points mean = draw();
    std::vector<Points> directions, shapes;
    for (int k = 0; k < rank; ++k) directions.push_back(draw() * std::pow(0.5, k) * 0.01);
    for (int i = 0; i < count; ++i) {
        shapes.push_back(mean);
        for (const Points& direction : directions) shapes.back() += random.normal() * direction;
    }
    return shapes;
}

std::vector<const Points*> pointers(const std::vector<Points>& shapes)
{
    std::vector<const Points*> result;
    for (const Points& shape : shapes) result.push_back(&shape);
    return result;
}

}  // namespace

TEST_CASE("The shape space of low-rank shapes is exact", "[shape_space]")
{
    const auto shapes = low_rank_shapes(30, 5, 40);
    const ShapeSpace space = fit_shape_space(pointers(shapes), 300, 1.0);
    REQUIRE(space.dimension() == 5);
    CHECK(space.explained_variance == Approx(1.0).margin(1e-12));
    CHECK((space.components.transpose() * space.components - Eigen::MatrixXd::Identity(5, 5)).norm() < 1e-12);
    RowMatrix codes(30, 5);
    for (std::size_t i = 0; i < shapes.size(); ++i) {
        const Eigen::VectorXd code = space.encode(shapes[i]);
        codes.row(static_cast<Eigen::Index>(i)) = code.transpose();
        CHECK((space.decode(code) - shapes[i]).cwiseAbs().maxCoeff() < 1e-12);
        CHECK((space.encode(space.decode(code)) - code).norm() < 1e-12);
    }
    // Codes of the training bodies have mean zero, are uncorrelated, and have the standard deviations stored.
    CHECK(codes.colwise().mean().norm() < 1e-12);
    const Eigen::MatrixXd covariance = codes.transpose() * codes / 29.0;
    const Eigen::MatrixXd expected = space.standard_deviations.array().square().matrix().asDiagonal();
    CHECK((covariance - expected).norm() < 1e-10 * expected.norm());
    for (int k = 1; k < 5; ++k) CHECK(space.standard_deviations[k] <= space.standard_deviations[k - 1]);
    for (int k = 0; k < 5; ++k) {
        Eigen::Index largest = 0;
        space.components.col(k).cwiseAbs().maxCoeff(&largest);
        CHECK(space.components(largest, k) > 0.0);
    }
}

TEST_CASE("The shape space stops at the wanted components or variance", "[shape_space]")
{
    const auto shapes = low_rank_shapes(30, 8, 40);
    const ShapeSpace full = fit_shape_space(pointers(shapes), 300, 1.0);
    const ShapeSpace two = fit_shape_space(pointers(shapes), 2, 1.0);
    REQUIRE(two.dimension() == 2);
    const Eigen::VectorXd variances = full.standard_deviations.array().square();
    CHECK(two.explained_variance == Approx(variances.head<2>().sum() / variances.sum()).epsilon(1e-9));
    const ShapeSpace some = fit_shape_space(pointers(shapes), 300, 0.95);
    REQUIRE(some.dimension() < full.dimension());
    CHECK(some.explained_variance >= 0.95);
    CHECK(variances.head(some.dimension() - 1).sum() / variances.sum() < 0.95);
    // Two bodies span one direction.
    CHECK(fit_shape_space({&shapes[0], &shapes[1]}, 300, 1.0).dimension() == 1);
}

TEST_CASE("A shape space needs different bodies of one size", "[shape_space]")
{
    const auto shapes = low_rank_shapes(3, 2, 10);
    const Points smaller = shapes[0].topRows(9);
    CHECK_THROWS_AS(fit_shape_space({&shapes[0]}, 10, 1.0), InputError);
    CHECK_THROWS_AS(fit_shape_space({&shapes[0], &shapes[0]}, 10, 1.0), InputError);
    CHECK_THROWS_AS(fit_shape_space({&shapes[0], &smaller}, 10, 1.0), Error);
    CHECK_THROWS_AS(fit_shape_space(pointers(shapes), 0, 1.0), InputError);
    CHECK_THROWS_AS(fit_shape_space(pointers(shapes), 10, 1.5), InputError);
    const ShapeSpace space = fit_shape_space(pointers(shapes), 10, 1.0);
    CHECK_THROWS_AS(space.encode(smaller), Error);
    CHECK_THROWS_AS(space.decode(Eigen::VectorXd::Zero(space.dimension() + 1)), Error);
}

TEST_CASE("More shapes than coordinates give the eigenvectors of their covariance", "[shape_space]")
{
    const auto shapes = low_rank_shapes(60, 6, 5);
    const ShapeSpace space = fit_shape_space(pointers(shapes), 300, 1.0);
    REQUIRE(space.dimension() == 6);
    // A few of them, by the other way, explain what both share: the same total of variances.
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(15);
    for (const Points& shape : shapes) mean += Eigen::Map<const Eigen::VectorXd>(shape.data(), 15) / 60.0;
    CHECK((space.mean - mean).norm() < 1e-12);
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(15, 15);
    for (const Points& shape : shapes) {
        const Eigen::VectorXd centred = Eigen::Map<const Eigen::VectorXd>(shape.data(), 15) - mean;
        covariance += centred * centred.transpose() / 59.0;
    }
    const Eigen::MatrixXd scaled = space.components * space.standard_deviations.cwiseAbs2().asDiagonal();
    CHECK((covariance * space.components - scaled).norm() < 1e-10 * covariance.norm());
    CHECK((space.components.transpose() * space.components - Eigen::MatrixXd::Identity(6, 6)).norm() < 1e-10);
}

TEST_CASE("Explained variances and errors of truncated codes", "[shape_space]")
{
    const auto shapes = low_rank_shapes(30, 8, 900);  // more coordinates than one block
    const ShapeSpace space = fit_shape_space(pointers(shapes), 300, 1.0);
    const Eigen::VectorXd shares = explained_variances(space);
    REQUIRE(shares.size() == space.dimension());
    CHECK(shares[shares.size() - 1] == Approx(space.explained_variance));
    // The squared error left by k components is the variance they do not explain.
    double total = 0.0;
    for (const Points& shape : shapes)
        total += (Eigen::Map<const Eigen::VectorXd>(shape.data(), shape.size()) - space.mean).squaredNorm();
    for (const int k : {1, 3, 6}) {
        CHECK(shares[k - 1] == Approx(fit_shape_space(pointers(shapes), k, 1.0).explained_variance));
        double left = 0.0, worst = 0.0;
        for (const Points& shape : shapes) {
            const ShapeSpace few = fit_shape_space(pointers(shapes), k, 1.0);
            const Points error = few.decode(few.encode(shape)) - shape;
            left += error.squaredNorm();
            worst = std::max(worst, error.rowwise().norm().maxCoeff());
        }
        CHECK(left / total == Approx(1.0 - shares[k - 1]).epsilon(1e-6));
        const ReconstructionErrors errors = reconstruction_errors(space, pointers(shapes), k);
        CHECK(errors.largest == Approx(worst).epsilon(1e-6));
        CHECK(errors.means.size() == shapes.size());
    }
    CHECK_THROWS_AS(reconstruction_errors(space, pointers(shapes), 100), Error);
}
