// SPDX-License-Identifier: Apache-2.0
// An assembled body, a tube: derivatives, invariances, patch test, Newton's method.
#include "bending_simulation.h"
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/simulation/simulator.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;

namespace {

Points jittered(const Points& points, int first_row, double spread)
{
    Points result = points;
    Random random(5, "fem-jitter");
    for (Eigen::Index i = first_row; i < points.rows(); ++i) {
        for (int c = 0; c < 3; ++c) result(i, c) += spread * random.normal();
    }
    return result;
}

Eigen::Matrix3d some_rotation()
{
    return Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
}

Points moved(const Points& points, const Eigen::Matrix3d& linear, const Eigen::RowVector3d& offset)
{
    Points result = points * linear.transpose();
    result.rowwise() += offset;
    return result;
}

/// The tube seen in a mirror: x -> -x, triangles turned round.
Template mirrored_tube(const Template& tube)
{
    Template mirror = tube;
    for (Points* points : {&mirror.rest.volume_vertices, &mirror.rest.skin_vertices, &mirror.rest.interior_vertices,
                           &mirror.rest.joint_positions}) {
        points->col(0) = -points->col(0);
    }
    mirror.wrap_triangles.col(1) = tube.wrap_triangles.col(2);
    mirror.wrap_triangles.col(2) = tube.wrap_triangles.col(1);
    mirror.prisms = layer_prisms(mirror.wrap_triangles, mirror.num_wrap_vertices());
    return mirror;
}

/// Two flat layers of right prisms over an uneven grid; only what layered_body() needs is filled.
Template slab_template(int size)
{
    Template slab;
    const int num_wrap = size * size;
    Random random(9, "slab");
    slab.rest.volume_vertices.resize(3 * num_wrap, 3);
    for (int i = 0; i < size; ++i) {
        for (int j = 0; j < size; ++j) {
            const double x = 0.02 * (i + 0.3 * random.uniform()), y = 0.02 * (j + 0.3 * random.uniform());
            for (int layer = 0; layer < 3; ++layer) {
                slab.rest.volume_vertices.row(layer * num_wrap + i * size + j) << x, y, 0.015 * layer;
            }
            slab.wrap_to_skin.push_back(i * size + j);
        }
    }
    slab.wrap_triangles.resize(2 * (size - 1) * (size - 1), 3);
    Eigen::Index row = 0;
    for (int i = 0; i + 1 < size; ++i) {
        for (int j = 0; j + 1 < size; ++j) {
            const int a = i * size + j, b = a + size;
            slab.wrap_triangles.row(row++) << a, b, b + 1;
            slab.wrap_triangles.row(row++) << a, b + 1, a + 1;
        }
    }
    slab.prisms = layer_prisms(slab.wrap_triangles, num_wrap);
    return slab;
}

double largest_distance(const Points& a, const Points& b)
{
    return (a - b).rowwise().norm().maxCoeff();
}

}  // namespace

TEST_CASE("A rigid motion costs nothing and exerts no force")
{
    const Template tube = test::tube_template(4, 6);
    const ElasticBody elastic = layered_body(tube, MaterialOptions{});
    const Objective objective(elastic);
    const Points& rest = tube.rest.volume_vertices;
    const Points turned = moved(rest, some_rotation(), {0.3, -0.2, 1});
    const auto gradients = deformation_gradients(gradient_operator(rest, tube.prisms), turned);
    Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rotation = some_rotation();
    for (Eigen::Index p = 0; p < gradients.rows(); ++p) {
        REQUIRE((gradients.row(p) - Eigen::Map<const Eigen::Matrix<double, 1, 9>>(rotation.data())).norm() < 1e-10);
    }
    const double scale = objective.energy(jittered(rest, 0, 0.003));
    REQUIRE(scale > 1e-3);
    REQUIRE(std::abs(objective.energy(rest)) < 1e-12 * scale);
    REQUIRE(std::abs(objective.energy(turned)) < 1e-9 * scale);
    Eigen::VectorXd gradient, absolute;
    objective.gradient(turned, gradient, absolute);
    REQUIRE(gradient.norm() < 1e-8);
}

TEST_CASE("Patch test: an affine field is an equilibrium of homogeneous flesh")
{
    // On right prisms the operator of a prism is the mean gradient of the trilinear field, so a constant stress must
    // balance at every vertex surrounded by flesh: the muscle wrap away from the rim.
    constexpr int size = 6;
    const Template slab = slab_template(size);
    MaterialOptions material;
    material.young_fat_pascal = material.young_muscle_pascal;
    material.stretch_stiffness = 0;
    material.bend_stiffness = 0;
    const ElasticBody elastic = layered_body(slab, material);
    const Objective objective(elastic);
    Eigen::Matrix3d affine;
    affine << 1.1, 0.1, -0.05, 0.02, 0.95, 0.08, -0.04, 0.03, 1.05;
    const Points x = moved(slab.rest.volume_vertices, affine, {0.1, 0, 0});
    Eigen::VectorXd gradient, absolute;
    objective.gradient(x, gradient, absolute);
    double inside = 0, forces = 0;
    for (int i = 1; i + 1 < size; ++i) {
        for (int j = 1; j + 1 < size; ++j) {
            inside = std::max(inside, gradient.segment<3>(3 * (i * size + j)).norm());
            forces = std::max(forces, absolute.segment<3>(3 * (i * size + j)).norm());
        }
    }
    REQUIRE(forces > 0.1);
    REQUIRE(gradient.tail(3 * size * size).norm() > 0.1);
    REQUIRE(inside < 1e-10 * forces);
}

TEST_CASE("A bent tube comes to equilibrium, its energy falling with every iteration")
{
    const Template tube = test::tube_template(12, 8);
    Simulator simulator(tube, test::bending_simulation());
    simulator.set_body(tube.rest);
    const SimulationResult result = simulator.simulate(test::tube_pose(0.9));
    REQUIRE(result.newton.converged());
    REQUIRE(result.newton.residual_relative <= 1e-5);
    REQUIRE(result.newton.iterations > 1);
    REQUIRE(result.load_steps == 0);
    double energy = result.newton.start_energy_joule;
    for (const NewtonIteration& iteration : result.newton.history) {
        REQUIRE(iteration.energy_joule < energy);
        energy = iteration.energy_joule;
    }
    REQUIRE(simulator.objective().energy(result.vertices) == Approx(result.newton.energy_joule));
    REQUIRE(largest_distance(result.vertices, tube.rest.volume_vertices) > 0.1);
    // Nothing near the solution has less energy.
    for (const double spread : {1e-5, 1e-4}) {
        const Points near = jittered(result.vertices, tube.num_wrap_vertices(), spread);
        REQUIRE(simulator.objective().energy(near) > result.newton.energy_joule);
    }
    // The result does not depend on what was simulated before.
    Simulator fresh(tube, test::bending_simulation());
    fresh.set_body(tube.rest);
    fresh.simulate(test::tube_pose(-0.4));
    REQUIRE((fresh.simulate(test::tube_pose(0.9)).vertices - result.vertices).norm() == 0);
}

TEST_CASE("Identity pose gives the rest shape")
{
    const Template tube = test::tube_template(6, 6);
    Simulator simulator(tube, test::bending_simulation());
    simulator.set_body(tube.rest);
    const SimulationResult result = simulator.simulate(Pose::rest(tube.skeleton.num_joints()));
    REQUIRE(result.newton.converged());
    REQUIRE(largest_distance(result.vertices, tube.rest.volume_vertices) < 1e-9);
    REQUIRE(result.inverted_prisms.by_volume == 0);
    REQUIRE(result.inverted_prisms.at_corners == 0);
    REQUIRE(result.intersecting_triangles == 0);
}

TEST_CASE("Turning the root turns the result")
{
    const Template tube = test::tube_template(8, 6);
    SimulationOptions options = test::bending_simulation();
    options.newton.relative_tolerance = 1e-9;
    Simulator simulator(tube, options);
    simulator.set_body(tube.rest);
    Pose pose = test::tube_pose(0.7);
    const Points upright = simulator.simulate(pose).vertices;
    pose.parent_from_joint[0] = some_rotation() * pose.parent_from_joint[0];
    pose.root_translation = Eigen::Vector3d(0.2, 1, -0.4);
    const Points turned = simulator.simulate(pose).vertices;
    const Eigen::RowVector3d root = tube.rest.joint_positions.row(0);
    const Points expected =
        moved(upright, some_rotation(), root + pose.root_translation.transpose() - root * some_rotation().transpose());
    REQUIRE(largest_distance(turned, upright) > 0.1);
    REQUIRE(largest_distance(turned, expected) < 1e-6);
}

TEST_CASE("A mirrored body in the mirrored pose deforms as the mirror image")
{
    const Template tube = test::tube_template(8, 6), mirror = mirrored_tube(tube);
    SimulationOptions options = test::bending_simulation();
    options.newton.relative_tolerance = 1e-9;
    Simulator simulator(tube, options), mirror_simulator(mirror, options);
    simulator.set_body(tube.rest);
    mirror_simulator.set_body(mirror.rest);
    const Points bent = simulator.simulate(test::tube_pose(0.7)).vertices;
    Points reflected = mirror_simulator.simulate(test::tube_pose(-0.7)).vertices;
    REQUIRE(largest_distance(bent, reflected) > 0.1);
    reflected.col(0) = -reflected.col(0);
    REQUIRE(largest_distance(bent, reflected) < 1e-6);
}

TEST_CASE("Load steps lead where the direct solve is not allowed to go")
{
    const Template tube = test::tube_template(8, 6);
    SimulationOptions options = test::bending_simulation();
    Simulator direct(tube, options);
    direct.set_body(tube.rest);
    const SimulationResult expected = direct.simulate(test::tube_pose(0.9));
    REQUIRE(expected.newton.converged());

    options.newton.max_iterations = expected.newton.iterations - 1;
    options.load_steps = 4;
    Simulator stepped(tube, options);
    stepped.set_body(tube.rest);
    const SimulationResult result = stepped.simulate(test::tube_pose(0.9));
    REQUIRE(result.load_steps == 4);
    REQUIRE(result.newton.iterations > options.newton.max_iterations);
    REQUIRE(result.newton.converged());
    REQUIRE(largest_distance(result.vertices, expected.vertices) < 1e-4);

    options.load_steps = 0;
    Simulator failing(tube, options);
    failing.set_body(tube.rest);
    const SimulationResult failed = failing.simulate(test::tube_pose(0.9));
    REQUIRE_FALSE(failed.newton.converged());
    REQUIRE(failed.newton.stop == NewtonStop::iteration_limit);
}

TEST_CASE("A pose scaled by one half twists half as far")
{
    Pose pose = test::tube_pose(0.8);
    pose.root_translation = Eigen::Vector3d(1, 2, 3);
    const Pose half = scale_pose(pose, 0.5), expected = test::tube_pose(0.4);
    for (std::size_t j = 0; j < half.parent_from_joint.size(); ++j) {
        REQUIRE((half.parent_from_joint[j] - expected.parent_from_joint[j]).norm() < 1e-12);
    }
    REQUIRE((half.root_translation - Eigen::Vector3d(0.5, 1, 1.5)).norm() < 1e-12);
}
