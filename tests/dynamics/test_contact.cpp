// SPDX-License-Identifier: Apache-2.0
// Soft bodies against obstacles, thrown things, themselves. World::step() checks every frame that nothing passes
// through anything.
#include "contact_world.h"

#include "ndg/core/error.h"
#include "ndg/geometry/rotation.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;
using test::box_body;
using test::make_obstacle;
using test::World;
using test::WorldOptions;

namespace {

bool at_bottom(const Eigen::Vector3d& s)
{
    return s[1] == 0;
}

Obstacle thrown(TriangleMesh shape, const Eigen::Vector3d& position, const Eigen::Vector3d& velocity, double mass)
{
    Obstacle obstacle = make_obstacle("ball", std::move(shape), position);
    obstacle.free = true;
    obstacle.mass_kg = mass;
    obstacle.velocity = velocity;
    return obstacle;
}

/// 20 x 6 x 20 cm, held below.
test::SoftBody cushion()
{
    return box_body({6, 3, 6}, {-0.1, 0, -0.1}, {0.1, 0.06, 0.1}, at_bottom);
}

Obstacle moving(Obstacle obstacle, const Eigen::Vector3d& velocity)
{
    obstacle.velocity = velocity;
    return obstacle;
}

}  // namespace

TEST_CASE("A ball dropped on a soft block comes to rest above it, borne by contact")
{
    WorldOptions options;
    options.young_pascal = 1e4;
    World world(cushion(), {thrown(sphere_shape(0.04, 0.02), {0.005, 0.12, 0}, {0, 0, 0}, 0.2)}, {}, options);
    world.run(1.0);
    const Interaction::Rows rows = world.interaction().obstacle_rows()[0];
    const Eigen::Vector3d force = world.force_on(rows.first, rows.count);
    CHECK(force[1] == Approx(0.2 * 9.81).epsilon(0.02));
    CHECK(world.force_on(world.interaction().body_begin(), rows.first - world.interaction().body_begin())[1] ==
          Approx(-force[1]).epsilon(1e-9));
    const Points ball = world.obstacle_positions(0);
    CHECK(world.state().velocities.bottomRows(rows.count).rowwise().norm().maxCoeff() < 0.02);
    // It dents the block: its lowest point lies below where the block's top was, and above its bottom.
    CHECK(ball.col(1).minCoeff() < 0.06);
    CHECK(ball.col(1).minCoeff() > 0.02);
}

TEST_CASE("A small fast ball does not tunnel through a thin sheet")
{
    WorldOptions options;
    options.young_pascal = 1e5;
    const auto rim = [](const Eigen::Vector3d& s) { return s[0] == 0 || s[0] == 1 || s[2] == 0 || s[2] == 1; };
    // 17 cm a step, through 1 cm.
    World world(box_body({6, 1, 6}, {-0.1, 0, -0.1}, {0.1, 0.01, 0.1}, rim),
                {thrown(sphere_shape(0.02, 0.015), {0.003, 0.2, 0.002}, {0, -20, 0}, 0.02)}, {}, options);
    double lowest = 1;
    for (int i = 0; i < 6; ++i) {
        world.step();
        lowest = std::min(lowest, world.state().velocities.bottomRows<1>()[1]);
    }
    CHECK(lowest < -19);
    CHECK(world.state().velocities.bottomRows<1>()[1] > -8);
    // Still above the sheet's middle.
    CHECK(world.obstacle_positions(0).col(1).minCoeff() > world.body_positions().col(1).minCoeff());
}

TEST_CASE("A free ball that hits a free block leaves momentum as it was")
{
    WorldOptions options;
    options.gravity.setZero();
    options.tolerance = 1e-9;
    World world(box_body({3, 3, 3}, {-0.05, -0.05, -0.05}, {0.05, 0.05, 0.05}),
                {thrown(sphere_shape(0.04, 0.03), {-0.12, 0.02, 0.01}, {2, 0, 0}, 0.3)}, {}, options);
    const Eigen::Vector3d before = world.momentum();
    CHECK(before[0] == Approx(0.6));
    world.run(0.15);
    CHECK((world.momentum() - before).norm() < 1e-6 * before.norm());
    const Interaction::Rows rows = world.interaction().obstacle_rows()[0];
    const double ball = (world.state().velocities.middleRows(rows.first, rows.count).transpose() *
                         world.masses().segment(rows.first, rows.count))[0];
    CHECK(ball < 0.4);  // it has given some away
}

TEST_CASE("Capsules and meshes that move press a body in and do not enter it")
{
    const Eigen::Vector3d down(0, -0.1, 0);
    Obstacle capsule = moving(make_obstacle("capsule", capsule_shape(0.02, 0.08, 0.015), {0, 0.085, 0}), down);
    capsule.keys[0].rotation = Eigen::Quaterniond(about_x(M_PI / 2));
    // A closed mesh: an octahedron, point down.
    TriangleMesh octahedron{Points(6, 3), Triangles(8, 3)};
    octahedron.vertices << 0.03, 0, 0, -0.03, 0, 0, 0, 0.03, 0, 0, -0.03, 0, 0, 0, 0.03, 0, 0, -0.03;
    octahedron.triangles << 2, 4, 0, 2, 1, 4, 2, 5, 1, 2, 0, 5, 3, 0, 4, 3, 4, 1, 3, 1, 5, 3, 5, 0;
    REQUIRE(closed_surface_defect(octahedron.vertices, octahedron.triangles).empty());
    const Obstacle mesh = moving(make_obstacle("mesh", octahedron, {0.011, 0.095, 0.007}), down);
    for (const Obstacle& obstacle : {capsule, mesh}) {
        WorldOptions options;
        options.gravity.setZero();
        World world(cushion(), {obstacle}, {}, options);
        world.run(0.25);
        // It is where it was told to be, 2 cm below the old top at least, and the body lies below it.
        const Points expected = obstacle.vertices(world.time());
        CHECK((world.obstacle_positions(0) - expected).norm() < 1e-12);
        CHECK(expected.col(1).minCoeff() < 0.045);
        CHECK(world.force_on(0, static_cast<int>(expected.rows()))[1] > 0.5);
    }
}

TEST_CASE("An obstacle that moves farther than the body is thick in one step pushes it along")
{
    WorldOptions options;
    options.gravity.setZero();
    // 2.5 cm a step, against a free block of 4 cm.
    World world(box_body({2, 2, 2}, {-0.02, -0.02, -0.02}, {0.02, 0.02, 0.02}),
                {moving(make_obstacle("bat", sphere_shape(0.05, 0.03), {-0.1, 0, 0}), {3, 0, 0})}, {}, options);
    world.run(0.1);
    CHECK((world.obstacle_positions(0).colwise().mean() - Eigen::RowVector3d(0.2, 0, 0)).norm() < 1e-9);
    CHECK(world.body_positions().col(0).minCoeff() > 0.2);
}

TEST_CASE("A block is squeezed between two planes, and refuses to be crushed with one error")
{
    WorldOptions options;
    options.gravity.setZero();
    options.contact.contact_distance = 1e-3;
    Obstacle press = make_obstacle("press", plane_shape(0.3, 0.1), {0, 0.0615, 0});
    press.keys[0].rotation = Eigen::Quaterniond(about_x(M_PI));
    press.velocity = {0, -0.2, 0};
    options.tolerance = 1e-5;
    World world(box_body({2, 2, 2}, {-0.03, 1.5e-3, -0.03}, {0.03, 0.06, 0.03}), {test::ground(0, 0.3), press}, {},
                options);
    world.run(0.1);
    const Points block = world.body_positions();
    CHECK(block.col(1).maxCoeff() < 0.0415);
    CHECK(block.col(1).minCoeff() > 0);
    CHECK(block.col(0).maxCoeff() > 0.032);  // it gives way sideways
    const int num_ground = world.interaction().obstacle_rows()[0].count;
    CHECK(world.force_on(0, num_ground)[1] < -1);

    // The planes meet at 0.3 s; a little of the block is left until shortly before.
    try {
        world.run(0.3);
        FAIL("a block was crushed to nothing");
    } catch (const Error& error) {
        const std::string message = error.what();
        INFO(message);
        CHECK(message.find("press cannot go on at 0.") == 0);
        CHECK(world.time() > 0.25);
        CHECK(message.find("body is in its way") != std::string::npos);
    }
}

TEST_CASE("A strip folded by its ends falls onto itself and does not pass through itself")
{
    WorldOptions options;
    options.young_pascal = 1e4;
    // An open U lying on its side, held at the two ends; the upper arm sags onto the lower one, which lies on the
    // ground.
    const double inner = 0.012, thickness = 0.01, length = 0.16;
    const double bend = M_PI * (inner + 0.5 * thickness), way = 2 * length + bend;
    const auto place = [&](const Eigen::Vector3d& s) -> Eigen::Vector3d {
        const double along = way * s[0], up = thickness * (s[1] - 0.5), middle = inner + 0.5 * thickness;
        const double z = 0.04 * (s[2] - 0.5);
        if (along < length) return {along, -middle + up, z};
        if (along > length + bend) return {length - (along - length - bend), middle - up, z};
        const double angle = M_PI * (along - length) / bend;
        return {length + (middle - up) * std::sin(angle), -(middle - up) * std::cos(angle), z};
    };
    World world(test::brick_body({24, 1, 2}, place, [](const Eigen::Vector3d& s) { return s[0] == 0 || s[0] == 1; }),
                {test::ground(-inner - thickness - 1e-3, 0.8)}, {}, options);
    world.run(0.4);
    // Where the arms lie on each other their gap is less than the contact distance.
    double gap = 1;
    const Points x = world.body_positions();
    for (Eigen::Index i = 0; i < x.rows(); ++i) {
        if (x(i, 0) < 0.04 || x(i, 0) > 0.12) continue;
        for (Eigen::Index j = 0; j < x.rows(); ++j) {
            if ((x.row(i) - x.row(j)).norm() > 1.2 * thickness || x(j, 1) <= x(i, 1)) continue;
            if (std::abs(i - j) > 40) gap = std::min(gap, x(j, 1) - x(i, 1));
        }
    }
    CHECK(gap < 3e-3);
    CHECK(gap > 0);
}

TEST_CASE("What starts inside the body is refused with its depth")
{
    const auto refused = [](const Obstacle& obstacle, const std::string& text) {
        try {
            World world(cushion(), {obstacle});
            FAIL("accepted");
        } catch (const InputError& error) {
            const std::string message = error.what();
            INFO(message);
            CHECK(message.find(obstacle.name) != std::string::npos);
            CHECK(message.find(text) != std::string::npos);
        }
    };
    // One in the middle, one that dips in, one that only an edge of the body enters, and one that swallows the body.
    refused(make_obstacle("bullet", sphere_shape(0.01, 0.01), {0, 0.03, 0}), "bullet starts inside body");
    refused(make_obstacle("hand", sphere_shape(0.05, 0.02), {0, 0.1, 0}), "mm");
    refused(make_obstacle("room", sphere_shape(1, 0.3), {0, 0, 0}), "body starts inside room");
    refused(test::ground(0.02, 1), "starts inside");
    World accepted(cushion(), {make_obstacle("hand", sphere_shape(0.05, 0.02), {0, 0.112, 0})});
    CHECK(accepted.scene().surfaces().size() == 2);
}
