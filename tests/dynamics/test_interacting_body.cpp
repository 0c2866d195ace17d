// SPDX-License-Identifier: Apache-2.0
// A body that a motion drives, hit by a ball and in a sleeve; scenes that say so.
#include "soft_shapes.h"

#include "ndg/core/error.h"
#include "ndg/dynamics/interacting_body.h"
#include "ndg/dynamics/motion_simulation.h"
#include "ndg/dynamics/scene_file.h"
#include "ndg/dynamics/shifted_term.h"
#include "ndg/elastic/neo_hookean_lanes.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <fstream>

using namespace ndg;

namespace {

Obstacle ball_at(const Eigen::Vector3d& position, const Eigen::Vector3d& velocity)
{
    Obstacle ball;
    ball.name = "ball";
    ball.shape = sphere_shape(0.06, 0.05);
    ball.keys.push_back({0, position, Eigen::Quaterniond::Identity()});
    ball.velocity = velocity;
    ball.free = true;
    ball.mass_kg = 0.4;
    return ball;
}

GarmentPlan sleeve()
{
    GarmentPlan plan;
    plan.name = "sleeve";
    plan.from_joint = "left_upper_arm";
    plan.to_joint = "left_forearm";
    plan.from = 0.3;
    plan.to = 0.8;
    plan.edge = 0.05;
    plan.shrink_seconds = 0.1;
    return plan;
}

std::unique_ptr<InteractingBody> dressed_tube(const Template& tube, std::vector<Obstacle> obstacles,
                                              const std::vector<GarmentPlan>& garments)
{
    return std::make_unique<InteractingBody>(
        std::make_unique<SoftTissueBody>(test::soft_tube(tube, 8e3, 15e3), test::tube_poser(tube), TissueOptions(),
                                         1000),
        std::move(obstacles), garments, ContactSceneOptions());
}

Scene read_text(const std::string& text)
{
    const test::TemporaryFolder folder;
    std::ofstream(folder.file("scene.json")) << text;
    return read_scene(folder.file("scene.json"));
}

}  // namespace

TEST_CASE("A shifted term is the same term further down")
{
    const SoftBody block = test::soft_block({2, 2, 2}, {0.1, 0.1, 0.1}, 1e4, 1e4);
    const int count = block.num_vertices(), first = 5;
    TissueTerm inner = tissue_term(block, {TissueLaw::neo_hookean, DeformationSpace::world}, count);
    inner.term->set_rest(block.rest);
    ElasticBody shifted(first + count + 3, 0), own(count, 0);
    shifted.add(std::make_unique<ShiftedTerm>(*inner.term, first, first + count + 3));
    own.add(std::make_unique<ShiftedTerm>(*inner.term, 0, count));
    Points x = block.rest;
    for (Eigen::Index v = 0; v < x.rows(); ++v) x(v, 0) += 0.01 * std::sin(50 * x(v, 1) + 30 * x(v, 2));
    Points more = Points::Zero(first + count + 3, 3);
    more.middleRows(first, count) = x;
    const Objective a(shifted), b(own);
    REQUIRE(b.energy(x) > 1e-3);
    CHECK(a.energy(more) == b.energy(x));
    Eigen::VectorXd gradient, other, absolute;
    a.gradient(more, gradient, absolute);
    b.gradient(x, other, absolute);
    CHECK(gradient.segment(3 * first, 3 * count) == other);
    CHECK(gradient.head(3 * first).norm() == 0);
    Eigen::SparseMatrix<double> hessian = a.hessian_pattern(), other_hessian = b.hessian_pattern();
    a.hessian(more, HessianKind::exact, hessian);
    b.hessian(x, HessianKind::exact, other_hessian);
    CHECK((Eigen::MatrixXd(hessian).block(3 * first, 3 * first, 3 * count, 3 * count) - Eigen::MatrixXd(other_hessian))
              .norm() == 0);
}

TEST_CASE("A bending tube in a sleeve is hit by a ball; a run that goes on from a stored state is the same")
{
    const Template tube = test::tube_template(12, 10);
    std::vector<Pose> poses;
    for (int n = 0; n <= 40; ++n) poses.push_back(test::tube_pose(0.4 * std::min(1.0, n / 24.0)));
    DynamicsOptions options;
    options.frames_per_block = 5;
    options.newton.relative_tolerance = 1e-5;
    const auto body = dressed_tube(tube, {ball_at({0.3, 0.75, 0}, {-3, 1, 0})}, {sleeve()});
    const auto hook = body->hook();
    MotionSimulation simulation(*body, poses, {}, options, hook.get());
    REQUIRE(simulation.num_blocks() == 3);
    std::optional<DynamicState> state, before_last;
    DynamicBlock block;
    const Interaction::Rows ball = body->interaction().obstacle_rows()[0];
    for (int b = 0; b < simulation.num_blocks(); ++b) {
        before_last = state;
        block = simulation.run(b, state);
        for (const double converged : block.statistics.at("converged")) CHECK(converged == 1);
        state = block.state;
        CHECK(find_penetrations(body->scene().surfaces(), state->positions, body->num_held()).empty());
        // In between too: single precision keeps a fiftieth of the contact distance apart.
        for (const std::vector<float>& frame : block.vertices) {
            const Points x = Eigen::Map<const RowMatrixF>(frame.data(), static_cast<Eigen::Index>(frame.size() / 3), 3)
                                 .cast<double>();
            CHECK(find_penetrations(body->scene().surfaces(), x, body->num_held()).empty());
        }
    }
    // It came from the right and goes back; flesh without weight of its own does not keep it from falling.
    CHECK(state->velocities.middleRows(ball.first, ball.count).col(0).mean() > -1);
    CHECK(state->velocities.middleRows(ball.first, ball.count).col(1).mean() < 0.5);

    const auto second = dressed_tube(tube, {ball_at({0.3, 0.75, 0}, {-3, 1, 0})}, {sleeve()});
    const auto second_hook = second->hook();
    MotionSimulation again(*second, poses, {}, options, second_hook.get());
    const DynamicBlock resumed = again.run(2, before_last);
    CHECK(resumed.state.positions == state->positions);
    CHECK(resumed.state.velocities == state->velocities);
}

TEST_CASE("An obstacle that follows a joint goes with it")
{
    const Template tube = test::tube_template(12, 10);
    Obstacle clamp;
    clamp.name = "clamp";
    clamp.shape = box_shape({0.04, 0.08, 0.2}, 0.05);
    // Beside the forearm at rest, nearer at the end.
    const double reach = tube.rest.skin_vertices.col(0).maxCoeff() + 0.02 + 0.004;
    const Eigen::RowVector3d elbow = tube.rest.joint_positions.row(tube.skeleton.joint("left_forearm"));
    const double height = 0.5 * (elbow[1] + tube.rest.skin_vertices.col(1).minCoeff());
    clamp.keys.push_back({0, {reach, height, 0}, Eigen::Quaterniond::Identity()});
    clamp.keys.push_back({0.1, {reach - 0.015, height, 0}, Eigen::Quaterniond::Identity()});
    clamp.follows = "left_forearm";
    std::vector<Pose> poses;
    for (int n = 0; n <= 16; ++n) poses.push_back(test::tube_pose(0.5 * n / 16));
    const auto body = dressed_tube(tube, {clamp}, {});
    REQUIRE(body->other_surfaces().size() == 1);
    CHECK(body->other_surfaces()[0].name == "clamp");
    CHECK_FALSE(body->other_surfaces()[0].garment);
    const auto hook = body->hook();
    MotionSimulation simulation(*body, poses, {}, {}, hook.get());
    std::optional<DynamicState> state;
    for (int b = 0; b < simulation.num_blocks(); ++b) {
        const DynamicBlock block = simulation.run(b, state);
        for (const double converged : block.statistics.at("converged")) CHECK(converged == 1);
        state = block.state;
    }
    const Interaction::Rows rows = body->interaction().obstacle_rows()[0];
    const std::vector<Eigen::Isometry3d> motions =
        forward_kinematics(body->skeleton(), body->joint_positions(), poses.back());
    const Eigen::Isometry3d motion = motions[static_cast<std::size_t>(body->skeleton().joint("left_forearm"))];
    CHECK((motion.matrix() - Eigen::Matrix4d::Identity()).norm() > 0.3);
    const Points expected = clamp.vertices(16 / 120.0, motion);
    CHECK((state->positions.middleRows(rows.first, rows.count) - expected).rowwise().norm().maxCoeff() < 1e-12);
    CHECK(find_penetrations(body->scene().surfaces(), state->positions, body->num_held()).empty());
    clamp.follows = "left_wing";
    CHECK_THROWS_WITH(dressed_tube(tube, {clamp}, {}), Catch::Contains("left_wing"));
}

TEST_CASE("A box is closed, turned outwards and of its size; contact of skin alone is asked for by a scene")
{
    const TriangleMesh box = box_shape({0.3, 0.1, 0.2}, 0.04);
    CHECK(closed_surface_defect(box.vertices, box.triangles).empty());
    CHECK(enclosed_volume(box.vertices, box.triangles) == Approx(0.3 * 0.1 * 0.2));
    CHECK(box.vertices.colwise().maxCoeff().isApprox(Eigen::RowVector3d(0.15, 0.05, 0.1)));
    double longest = 0;
    for (Eigen::Index t = 0; t < box.triangles.rows(); ++t) {
        for (int k = 0; k < 3; ++k) {
            const auto a = box.vertices.row(box.triangles(t, k)), b = box.vertices.row(box.triangles(t, (k + 1) % 3));
            longest = std::max(longest, (a - b).norm());
        }
    }
    CHECK(longest <= 0.04 * std::sqrt(2.0) + 1e-12);
    CHECK(read_text(R"({"contact": true})").contact);
    CHECK_FALSE(read_text("{}").contact);
}

TEST_CASE("What starts inside the driven body is refused, and so is a garment on a joint that is not there")
{
    const Template tube = test::tube_template(12, 10);
    const auto body = dressed_tube(tube, {ball_at({0.1, 0.5, 0}, {0, 0, 0})}, {});
    const auto hook = body->hook();
    MotionSimulation simulation(*body, {test::tube_pose(0)}, {}, {}, hook.get());
    CHECK_THROWS_AS(simulation.run(0, std::nullopt), InputError);
    GarmentPlan nowhere = sleeve();
    nowhere.from_joint = "left_wing";
    CHECK_THROWS_AS(dressed_tube(tube, {}, {nowhere}), InputError);
}

TEST_CASE("Scenes say what is met and worn, and are refused with the place where they are wrong")
{
    const Scene scene = read_text(R"({"obstacles": [
        {"type": "plane", "position": [0, -1, 0], "normal": [0, 1, 0], "friction": 0.7},
        {"name": "ball", "type": "sphere", "radius": 0.1, "edge": 0.05, "position": [0, 2, 0], "velocity": [0, -5, 0],
         "free": true, "mass_kg": 0.5},
        {"type": "capsule", "radius": 0.03, "length": 0.2, "keys": [{"time": 0, "position": [0, 0, 1]},
         {"time": 1, "position": [0, 0, 2], "rotation": [0, 0, 90]}]}],
      "garments": [{"type": "sleeve", "name": "band", "from_joint": "left_upper_arm", "to_joint": "left_forearm",
        "rest_share": 0.8}]})");
    REQUIRE(scene.obstacles.size() == 3);
    CHECK(scene.obstacles[0].friction == 0.7);
    CHECK(scene.obstacles[0].vertices(0).topRows(4).col(1).isConstant(-1));
    CHECK(scene.obstacles[1].free);
    for (const Obstacle& obstacle : scene.obstacles) {
        CHECK(closed_surface_defect(obstacle.shape.vertices, obstacle.shape.triangles).empty());
    }
    CHECK(enclosed_volume(scene.obstacles[1].shape.vertices, scene.obstacles[1].shape.triangles) ==
          Approx(4.0 / 3 * M_PI * 1e-3).epsilon(0.1));
    CHECK(enclosed_volume(scene.obstacles[2].shape.vertices, scene.obstacles[2].shape.triangles) ==
          Approx(M_PI * 9e-4 * 0.2 + 4.0 / 3 * M_PI * 2.7e-5).epsilon(0.15));
    // Half-way in time: half-way, turned by half the angle.
    const Eigen::Isometry3d half = scene.obstacles[2].world_from_obstacle(0.5);
    CHECK((half.translation() - Eigen::Vector3d(0, 0, 1.5)).norm() < 1e-12);
    CHECK(half.linear()(0, 0) == Approx(std::cos(M_PI / 4)));
    REQUIRE(scene.garments.size() == 1);
    CHECK(scene.garments[0].rest_share == 0.8);

    const auto refused = [](const std::string& text, const std::string& place) {
        try {
            read_text(text);
            FAIL("accepted " << text);
        } catch (const InputError& error) {
            INFO(error.what());
            CHECK(std::string(error.what()).find(place) != std::string::npos);
        }
    };
    refused(R"({"obstacles": [{"type": "cube"}]})", "obstacles[0].type");
    refused(R"({"obstacles": [{"type": "sphere"}]})", "radius");
    refused(R"({"obstacles": [{"type": "sphere", "radius": -1}]})", "obstacles[0].radius");
    refused(R"({"obstacles": [{"type": "box", "size": [1, 0, 1]}]})", "obstacles[0].size");
    refused(R"({"obstacles": [{"type": "sphere", "radius": 1, "free": true, "mass_kg": 1, "follows": "head"}]})",
            "follows");
    refused(R"({"obstacles": [{"type": "sphere", "radius": 1, "size": 2}]})", "size");
    refused(R"({"obstacles": [{"type": "sphere", "radius": 1, "mass_kg": 2}]})", "not \"free\"");
    refused(R"({"obstacles": [{"type": "plane", "free": true, "mass_kg": 2}]})", "plane");
    refused(R"({"obstacles": [{"type": "plane", "edge": 1e-3}]})", "triangles");
    refused(R"({"obstacles": [{"type": "mesh", "file": "none.obj"}]})", "none.obj");
    refused(R"({"obstacles": [{"type": "plane", "name": "a"}, {"type": "plane", "name": "a"}]})", "second");
    refused(R"({"obstacles": [{"type": "sphere", "radius": 1, "keys": [{"time": 1}, {"time": 1}]}]})", "keys[1].time");
    refused(R"({"garments": [{"type": "sleeve", "from_joint": "a", "to_joint": "b", "from": 0.6, "to": 0.5}]})", "0.6");
}

TEST_CASE("A thrown solid has the mass, centre and moments of inertia of its volume")
{
    const double radius = 0.1, mass = 2;
    const ObstacleSolid ball = solid_of(sphere_shape(radius, 0.02), mass);
    CHECK(ball.masses.sum() == Approx(mass));
    CHECK((ball.vertices.transpose() * ball.masses).norm() < 1e-9);
    double inertia = 0;
    for (Eigen::Index v = 0; v < ball.vertices.rows(); ++v) {
        inertia += ball.masses[v] * ball.vertices.row(v).head<2>().squaredNorm();
    }
    CHECK(inertia == Approx(0.4 * mass * radius * radius).epsilon(0.01));
    CHECK(tetrahedron_volumes(ball.vertices, ball.tetrahedra).minCoeff() > 0);
    // A long way off the origin, its centre is still its own.
    TriangleMesh moved = sphere_shape(radius, 0.05);
    moved.vertices.rowwise() += Eigen::RowVector3d(1, 2, 3);
    const ObstacleSolid far = solid_of(moved, mass);
    CHECK((far.vertices.bottomRows<1>() - Eigen::RowVector3d(1, 2, 3)).norm() < 1e-9);
}
