// SPDX-License-Identifier: Apache-2.0
#include "body_source/scattered_points.h"
#include "ndg/core/error.h"
#include "ndg/geometry/sphere.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;

TEST_CASE("Sphere fit finds a part of a sphere and ignores what hangs on it")
{
    const Eigen::RowVector3d centre(0.1, 0.9, -0.02);
    Points points = test::scattered_points(240, 1);
    points.rowwise().normalize();
    for (Eigen::Index i = 0; i < points.rows(); ++i) points(i, 1) = std::abs(points(i, 1));
    points = (0.024 * points).rowwise() + centre;
    const Sphere exact = fit_sphere(points);
    CHECK(exact.radius == Approx(0.024));
    CHECK((exact.centre.transpose() - centre).norm() < 1e-9);

    Points with_neck(points.rows() + 60, 3);
    with_neck << points, (0.01 * test::scattered_points(60, 2)).rowwise() + (centre - Eigen::RowVector3d(0, 0.03, 0));
    const Sphere robust = fit_sphere(with_neck);
    CHECK(robust.radius == Approx(0.024).epsilon(0.01));
    CHECK((robust.centre.transpose() - centre).norm() < 3e-4);

    CHECK_THROWS_AS(fit_sphere(points.topRows(3)), Error);
    Points flat = points;
    flat.col(2).setZero();
    CHECK_THROWS_AS(fit_sphere(flat), Error);
}
