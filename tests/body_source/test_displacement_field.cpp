// SPDX-License-Identifier: Apache-2.0
#include "body_source/scattered_points.h"
#include "ndg/body_source/displacement_field.h"

#include <catch2/catch.hpp>

using namespace ndg;

TEST_CASE("A displacement field reproduces what smoothness does not oppose")
{
    const Points points = 0.1 * test::scattered_points(400, 4);
    const Eigen::VectorXd ones = Eigen::VectorXd::Ones(points.rows());
    SECTION("a translation costs nothing")
    {
        Points wanted(points.rows(), 3);
        wanted.rowwise() = Eigen::RowVector3d(0.01, -0.02, 0.005);
        const DisplacementField field(points, wanted, ones, 0.03, {});
        CHECK((field.at(points) - wanted).cwiseAbs().maxCoeff() < 1e-6);
        CHECK(field.at(Points::Constant(1, 3, 5.0)).isZero());
    }
    SECTION("a linear field bends nothing")
    {
        Eigen::Matrix3d slope;
        slope << 0.02, 0.1, 0, -0.05, 0.03, 0.02, 0, 0.01, -0.04;
        const Points wanted = points * slope;
        const DisplacementField field(points, wanted, ones, 0.03, {0.0, 1.0});
        CHECK((field.at(points) - wanted).cwiseAbs().maxCoeff() < 2e-6);
    }
    SECTION("a push on one point takes its neighbours along and fades")
    {
        Points wanted = Points::Zero(points.rows(), 3);
        Eigen::VectorXd weights = Eigen::VectorXd::Constant(points.rows(), 0.01);
        wanted.row(0) << 0, 0.01, 0;
        weights[0] = 1.0;
        const DisplacementField field(points, wanted, weights, 0.02, {});
        const Points moved = field.at(points);
        CHECK(moved(0, 1) > 0.0005);
        CHECK(moved.cwiseAbs().maxCoeff() <= 0.0101);
        Eigen::Index farthest = 0;
        (points.rowwise() - points.row(0)).rowwise().norm().maxCoeff(&farthest);
        CHECK(moved.row(farthest).norm() < 0.2 * moved(0, 1));
    }
}
