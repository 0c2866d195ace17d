// SPDX-License-Identifier: Apache-2.0
#include "body_source/scattered_points.h"
#include "ndg/anatomical/fit.h"
#include "ndg/core/error.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;

TEST_CASE("Similarity fit recovers rotation, scale and place")
{
    const Points from = test::scattered_points(12, 3);
    const Eigen::Matrix3d rotation =
        Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
    const Eigen::Vector3d shift(0.3, -1.0, 2.0);
    const Points to = (1.7 * from * rotation.transpose()).rowwise() + shift.transpose();
    const Eigen::Affine3d fitted = fit_similarity(from, to);
    CHECK((fitted.linear() - 1.7 * rotation).norm() < 1e-9);
    CHECK((fitted.translation() - shift).norm() < 1e-9);
    CHECK_THROWS_AS(fit_similarity(from.topRows(2), to.topRows(2)), Error);
}

TEST_CASE("A bone's ends go to its joints, with one scale along and one across")
{
    const Eigen::Vector3d a(0.1, 1.3, 0.05), b(0.2, 1.0, 0.07), c(0.2, 1.4, 0.0), d(0.45, 1.2, 0.1);
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitY()).toRotationMatrix();
    const Eigen::Affine3d map = bone_transform(a, b, c, d, turn, 0.9);
    CHECK((map * a - c).norm() < 1e-12);
    CHECK((map * b - d).norm() < 1e-12);
    const Eigen::Vector3d across = (b - a).unitOrthogonal();
    CHECK((map.linear() * across).norm() == Approx(0.9));
    CHECK(std::abs((map.linear() * across).dot(d - c)) < 1e-12);
    CHECK(map.linear().determinant() == Approx(0.81 * (d - c).norm() / (b - a).norm()));
    CHECK_THROWS_AS(bone_transform(a, a, c, d, turn, 0.9), Error);

    const Eigen::Matrix3d frame = frame_along(b - a, Eigen::Vector3d::UnitZ());
    CHECK((frame.transpose() * frame).isIdentity(1e-12));
    CHECK(frame.determinant() == Approx(1.0));
    CHECK_THROWS_AS(frame_along(b - a, b - a), Error);
}
