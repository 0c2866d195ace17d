// SPDX-License-Identifier: Apache-2.0
// Friction: its energy, and blocks on slopes.
#include "contact_world.h"
#include "elastic/derivatives.h"
#include "ndg/core/random.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;

TEST_CASE("The norm of slipping is smooth and grows by the way beyond the least")
{
    const double stick = 2e-3;
    for (const double way : {1e-6, 5e-4, 1.5e-3, 1.99e-3, 2.5e-3, 0.1}) {
        const double step = 1e-6 * way;
        const SlipNorm here = slip_norm(way, stick), high = slip_norm(way + step, stick),
                       low = slip_norm(way - step, stick);
        REQUIRE(here.first_over_way * way == Approx((high.value - low.value) / (2 * step)).epsilon(1e-4));
        const double second = (high.first_over_way * (way + step) - low.first_over_way * (way - step)) / (2 * step);
        REQUIRE(here.second == Approx(second).epsilon(1e-4).margin(1e-3));
    }
    REQUIRE(slip_norm(0.1, stick).value == 0.1);
    REQUIRE(slip_norm(0, stick).value == Approx(stick / 3));
    REQUIRE(slip_norm(stick, stick).first_over_way == Approx(1 / stick));
}

TEST_CASE("Friction has the derivatives of its energy and pushes along the surface by the coefficient at most")
{
    Points start(8, 3);
    Random random(3, "friction");
    for (Eigen::Index i = 0; i < start.size(); ++i) start.data()[i] = random.normal();
    ElasticBody body(8, 0);
    auto owned = std::make_unique<FrictionTerm>(8);
    FrictionTerm* term = owned.get();
    body.add(std::move(owned));
    term->set_pairs(Stencils(4, {0, 1, 2, 3, 4, 5, 6, 7}, 8));
    const Eigen::Vector3d normal = Eigen::Vector3d(1, 2, -1).normalized();
    ContactForce first{30, normal, {1, -0.2, -0.5, -0.3}}, second{20, Eigen::Vector3d::UnitY(), {0.4, 0.6, -0.7, -0.3}};
    term->set_step({first, second}, {0.5, 0.25}, start, 0.05);
    const Objective objective(body);
    for (const double slip : {0.02, 0.3}) {  // one sticks, one slides
        Points x = start;
        for (Eigen::Index i = 0; i < x.size(); ++i) x.data()[i] += slip * random.normal();
        test::require_derivatives(objective, x);
        REQUIRE((test::hessian_of(objective, x, HessianKind::projected) -
                 test::hessian_of(objective, x, HessianKind::exact))
                    .norm() == 0);
    }
    // Slid by 0.1 along a tangent: mu N on the point, against the way, and as much back on the triangle.
    const Eigen::Vector3d tangent = normal.unitOrthogonal();
    Points x = start;
    x.row(0) += 0.1 * tangent.transpose() + 0.7 * normal.transpose();
    Eigen::VectorXd gradient, absolute;
    objective.gradient(x, gradient, absolute);
    REQUIRE((gradient.head<3>() - 15 * tangent).norm() < 1e-10);
    REQUIRE((gradient.segment<3>(3) + 0.2 * 15 * tangent).norm() < 1e-10);
    REQUIRE(gradient.tail<12>().norm() < 1e-10);
}

namespace {

/// Speed down a slope of a block that starts on it, and how much faster it has become in the second half of the time.
struct Slide {
    double speed = 0, acceleration = 0;
};

Slide slide(double angle, double friction, double seconds)
{
    test::WorldOptions options;
    // The slope is level, and gravity leans.
    options.gravity = 9.81 * Eigen::Vector3d(std::sin(angle), -std::cos(angle), 0);
    options.young_pascal = 2e5;
    options.contact.friction_skin_obstacle = friction;
    test::World world(test::box_body({3, 2, 3}, {-0.05, 1.5e-3, -0.05}, {0.05, 0.05, 0.05}), {test::ground(0, 6)}, {},
                      options);
    const auto speed = [&] { return world.momentum()[0] / world.masses().sum(); };
    world.run(seconds / 2);
    const double before = speed();
    world.run(seconds / 2);
    return {speed(), (speed() - before) / (seconds / 2)};
}

}  // namespace

TEST_CASE("A block on a slope sticks below the angle of friction and slides above it as Coulomb's law has it")
{
    constexpr double degree = M_PI / 180, friction = 0.5;  // 26.6 degrees
    const Slide below = slide(20 * degree, friction, 0.6);
    CHECK(std::abs(below.speed) < 1.1e-3);
    CHECK(std::abs(below.acceleration) < 1e-2);
    for (const double angle : {35 * degree, 45 * degree}) {
        const Slide above = slide(angle, friction, 0.6);
        CHECK(above.acceleration == Approx(9.81 * (std::sin(angle) - friction * std::cos(angle))).epsilon(0.02));
    }
    CHECK(slide(35 * degree, 0, 0.4).acceleration == Approx(9.81 * std::sin(35 * degree)).epsilon(1e-3));
}
