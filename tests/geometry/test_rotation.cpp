// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/random.h"
#include "ndg/geometry/rotation.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;

TEST_CASE("rotation vectors and rotations invert each other")
{
    Random random(6, "rotations");
    for (const double size : {1e-9, 1e-4, 0.5, 1.7}) {
        const Eigen::Vector3d vector = size * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
        if (vector.norm() > M_PI) continue;
        CHECK((rotation_vector(rotation_of(vector)) - vector).norm() < 1e-12 + 1e-9 * vector.norm());
    }
    CHECK(rotation_vector(Eigen::Matrix3d::Identity()).norm() == 0.0);
    const Eigen::Vector3d half_turn(0.0, M_PI, 0.0);
    CHECK(rotation_vector(rotation_of(half_turn)).norm() == Approx(M_PI));
}

TEST_CASE("a rotation is taken apart into swing and twist")
{
    const Eigen::Vector3d axis = Eigen::Vector3d(1.0, 2.0, -0.5).normalized(), across = axis.unitOrthogonal();
    for (const double twist : {-3.1, -0.4, 0.0, 1e-7, 2.0, 3.1}) {
        const Eigen::Matrix3d rotation = rotation_of(0.8 * across) * rotation_of(twist * axis);
        CHECK(twist_angle(rotation, axis) == Approx(twist).margin(1e-12));
    }
    CHECK((about_x(0.3) - rotation_of({0.3, 0.0, 0.0})).norm() < 1e-15);
    CHECK((about_y(0.3) - rotation_of({0.0, 0.3, 0.0})).norm() < 1e-15);
    CHECK((about_z(0.3) - rotation_of({0.0, 0.0, 0.3})).norm() < 1e-15);
}

TEST_CASE("the minimal rotation turns about the common normal, and half a turn has one too")
{
    const Eigen::Vector3d from(0.2, -1.0, 0.4), to(3.0, 1.0, -2.0);
    const Eigen::Matrix3d turn = minimal_rotation(from, to);
    CHECK((turn * from.normalized() - to.normalized()).norm() < 1e-12);
    CHECK((turn * from.cross(to).normalized() - from.cross(to).normalized()).norm() < 1e-12);
    const Eigen::Matrix3d opposite = minimal_rotation(from, -2.0 * from);
    CHECK((opposite * from + from).norm() < 1e-12);
    CHECK(opposite.determinant() == Approx(1.0));
}
