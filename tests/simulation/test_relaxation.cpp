// SPDX-License-Identifier: Apache-2.0
// Creases brought to rest by themselves, and flesh that may not invert.
#include "bending_simulation.h"
#include "ndg/core/random.h"
#include "ndg/simulation/local_relaxation.h"
#include "ndg/simulation/simulator.h"
#include "support/support.h"

#include <catch2/catch.hpp>

using namespace ndg;

TEST_CASE("A disturbed spot of the skin is relaxed by itself")
{
    const Template tube = test::tube_template(40, 16);
    const ElasticBody elastic = layered_body(tube, MaterialOptions{});
    const Objective objective(elastic);
    LocalRelaxation relaxation(objective);
    Points positions = tube.rest.volume_vertices;
    const int spot = 2 * tube.num_wrap_vertices() + 16 * 20;
    positions.row(spot) += Eigen::RowVector3d(0.004, 0.01, -0.006);
    Eigen::VectorXd before, after, absolute;
    objective.gradient(positions, before, absolute);
    const double energy = objective.energy(positions);
    const Points start = positions;
    REQUIRE(relaxation.relax(positions, before));
    objective.gradient(positions, after, absolute);
    REQUIRE(after.norm() < 0.1 * before.norm());
    REQUIRE(objective.energy(positions) < 0.1 * energy);
    // The far half has not moved.
    const Eigen::VectorXd moved = (positions - start).rowwise().norm();
    REQUIRE(moved(spot) > 0.005);
    REQUIRE((moved.array() > 0).count() < positions.rows() / 4);

    // Forces everywhere are left to the whole.
    Random random(3, "everywhere");
    for (Eigen::Index v = tube.num_wrap_vertices(); v < positions.rows(); ++v) {
        for (int c = 0; c < 3; ++c) positions(v, c) += 0.001 * random.uniform(-1, 1);
    }
    const Points shaken = positions;
    objective.gradient(positions, before, absolute);
    REQUIRE_FALSE(relaxation.relax(positions, before));
    REQUIRE((positions - shaken).norm() == 0);
}

TEST_CASE("With and without relaxed creases the equilibrium is one")
{
    const Template tube = test::tube_template(24, 12);
    SimulationOptions options = test::bending_simulation();
    options.newton.relative_tolerance = 1e-9;
    Simulator simulator(tube, options);
    simulator.set_body(tube.rest);
    const SimulationResult with = simulator.simulate(test::tube_pose(1.0));
    REQUIRE(with.newton.converged());

    const ElasticBody elastic = layered_body(tube, options.material);
    const Objective objective(elastic);
    Points positions = simulator.start(test::tube_pose(1.0));
    const NewtonResult without = NewtonSolver(objective).minimise(positions, options.newton);
    REQUIRE(without.converged());
    REQUIRE((positions - with.vertices).rowwise().norm().maxCoeff() < 1e-6);
    REQUIRE(without.energy_joule == Approx(with.newton.energy_joule).epsilon(1e-9));
}

TEST_CASE("Flesh with guarded volumes does not invert where the paper's does")
{
    // Every second vertex of the bone wrap pushed out through the skin.
    const Template tube = test::tube_template(16, 12);
    const int wrap = tube.num_wrap_vertices();
    Points start = tube.rest.volume_vertices;
    for (int v = 5; v < wrap; v += 2) start.row(v) += 4 * (start.row(wrap + v) - start.row(v));
    InvertedPrisms inverted[2];
    for (const bool guarded : {false, true}) {
        MaterialOptions material;
        material.energy = guarded ? FleshEnergy::inversion_free : FleshEnergy::paper;
        const ElasticBody elastic = layered_body(tube, material);
        const Objective objective(elastic);
        Points positions = start;
        NewtonOptions options;
        options.max_iterations = 200;
        REQUIRE(NewtonSolver(objective).minimise(positions, options).converged());
        inverted[guarded ? 1 : 0] = count_inverted_prisms(positions, tube.prisms);
    }
    CHECK(inverted[0].by_volume > 0);
    CHECK(inverted[1].by_volume == 0);
    CHECK(inverted[1].at_corners < inverted[0].at_corners / 4);
}
