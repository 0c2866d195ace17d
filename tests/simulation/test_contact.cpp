// SPDX-License-Identifier: Apache-2.0
// Skin kept from skin: a tube folded onto itself.
#include "bending_simulation.h"
#include "ndg/geometry/triangle_crossings.h"
#include "ndg/simulation/simulator.h"
#include "ndg/simulation/untangle.h"
#include "support/support.h"

#include <catch2/catch.hpp>

using namespace ndg;

namespace {

SimulationOptions with_contact(bool contact)
{
    SimulationOptions options = test::bending_simulation();
    options.contact.contact = contact;
    options.newton.max_iterations = 200;
    return options;
}

}  // namespace

TEST_CASE("A tube folded onto itself does not pass through itself with contact")
{
    const Template tube = test::tube_template(24, 12);
    const Pose pose = test::tube_pose(2.6);
    SimulationResult results[2];
    for (const bool contact : {false, true}) {
        Simulator simulator(tube, with_contact(contact));
        simulator.set_body(tube.rest);
        results[contact] = simulator.simulate(pose);
        REQUIRE(results[contact].newton.converged());
    }
    CHECK(results[0].intersecting_triangles > 0);
    CHECK(results[1].intersecting_triangles == 0);
    CHECK(results[1].newton.energy_joule > results[0].newton.energy_joule);

    // The same once more, with the same simulator: nothing is left of the last sample.
    Simulator simulator(tube, with_contact(true));
    simulator.set_body(tube.rest);
    simulator.simulate(test::tube_pose(2.2));
    CHECK(simulator.simulate(pose).vertices == results[1].vertices);
}

TEST_CASE("Where skin is far from skin, contact changes nothing")
{
    const Template tube = test::tube_template();
    SimulationResult results[2];
    for (const bool contact : {false, true}) {
        Simulator simulator(tube, with_contact(contact));
        simulator.set_body(tube.rest);
        results[contact] = simulator.simulate(test::tube_pose(0.5));
    }
    CHECK(results[1].vertices == results[0].vertices);
    CHECK(results[1].newton.iterations == results[0].newton.iterations);
}

TEST_CASE("Skin that passes through itself is drawn in as far as needed, and other skin not at all")
{
    const Template tube = test::tube_template(24, 12);
    Simulator simulator(tube, with_contact(false));
    simulator.set_body(tube.rest);
    const Points start = simulator.start(test::tube_pose(2.6));
    const int wrap = tube.num_wrap_vertices();
    REQUIRE(!crossing_triangles(start.bottomRows(wrap), tube.wrap_triangles).empty());
    Points positions = start;
    REQUIRE(untangle(positions, tube, 1e-3).empty());
    CHECK(crossing_triangles(positions.bottomRows(wrap), tube.wrap_triangles).empty());
    CHECK(positions.topRows(wrap) == start.topRows(wrap));
    const Eigen::VectorXd moved = (positions - start).rowwise().norm();
    CHECK((moved.array() == 0).count() > positions.rows() / 2);
    Points again = positions;
    CHECK(untangle(again, tube, 1e-3).empty());
    CHECK(again == positions);
}
