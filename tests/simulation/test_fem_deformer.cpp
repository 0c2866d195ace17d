// SPDX-License-Identifier: Apache-2.0
#include "bending_simulation.h"
#include "ndg/simulation/fem_deformer.h"

#include "ndg/simulation/simulator.h"
#include "simulation/sample_scene.h"

#include <catch2/catch.hpp>

using namespace ndg;

TEST_CASE("The simulation as a method gives what the simulator gives, whichever body comes next")
{
    const test::SampleScene scene;
    MethodTable table;
    register_fem(table);
    const auto fem = table.find("fem").make(BodyPoser(scene.tube, test::bending));
    const BodyPoser poser(scene.tube, test::bending);
    for (const int body_idx : {0, 1, 0}) {
        const Body& body = scene.bodies.bodies[body_idx];
        Simulator simulator(scene.tube, test::bending_simulation());
        simulator.set_body(body);
        for (const Pose& pose : {scene.poses.poses[1], scene.poses.poses[3]}) {
            CHECK(fem->deform(poser.pose(body, pose)) == simulator.simulate(pose).vertices);
        }
    }
}
