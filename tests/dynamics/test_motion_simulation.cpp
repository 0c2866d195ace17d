// SPDX-License-Identifier: Apache-2.0
// Bodies that a motion drives: where they come to rest, and what hangs on them.
#include "soft_shapes.h"

#include "ndg/core/error.h"
#include "ndg/dynamics/layered_driven_body.h"
#include "ndg/dynamics/motion_simulation.h"
#include "support/described.h"

#include <catch2/catch.hpp>

#include <fmt/format.h>

#include <cmath>

using namespace ndg;

namespace {

Points frame_of(const DynamicBlock& block, std::size_t frame)
{
    const std::vector<float>& values = block.vertices[frame];
    return Eigen::Map<const RowMatrixF>(values.data(), static_cast<Eigen::Index>(values.size() / 3), 3).cast<double>();
}

/// A bend of the tube's elbow from straight to `angle` in `bending` steps.
std::vector<Pose> bend(double angle, int bending)
{
    std::vector<Pose> poses;
    for (int n = 0; n <= bending; ++n) poses.push_back(test::tube_pose(angle * n / bending));
    return poses;
}

DynamicsOptions tight()
{
    DynamicsOptions options;
    options.newton = {1e-10, 1e-10, 100};
    return options;
}

/// The state at the end of a motion.
DynamicState run_through(MotionSimulation& simulation)
{
    std::optional<DynamicState> state;
    for (int b = 0; b < simulation.num_blocks(); ++b) {
        DynamicBlock block = simulation.run(b, state);
        for (const double converged : block.statistics.at("converged")) REQUIRE(converged == 1);
        state = std::move(block.state);
    }
    return *state;
}

}  // namespace

TEST_CASE("A bent tube comes to rest in the skinned shape in unposed space, and not in the world's")
{
    const Template tube = test::tube_template(9, 8);
    const SoftBody tissue = test::soft_tube(tube, 8e3, 15e3);
    const SoftBodyPoser poser = test::tube_poser(tube);
    const Points skinned = apply_maps(poser.world_from_unposed(test::tube_pose(1.1)), tissue.rest);
    DynamicsOptions options = tight();
    options.hold_seconds = 2;
    const auto error = [&](TissueLaw law, DeformationSpace space) {
        TissueOptions law_options;
        law_options.law = law;
        law_options.space = space;
        SoftTissueBody body(tissue, poser, law_options, 1000);
        MotionSimulation simulation(body, bend(1.1, 24), {}, options);
        REQUIRE(simulation.num_frames() == 67);
        const DynamicState end = run_through(simulation);
        REQUIRE((end.positions.topRows(tissue.num_held) - skinned.topRows(tissue.num_held)).norm() < 1e-12);
        REQUIRE(end.velocities.norm() < 1e-5);
        return (end.positions - skinned).rowwise().norm().maxCoeff();
    };
    for (const TissueLaw law : {TissueLaw::fung, TissueLaw::neo_hookean}) {
        const double unposed = error(law, DeformationSpace::unposed), world = error(law, DeformationSpace::world);
        WARN(fmt::format("{}: from the skinned shape {:.2e} mm by unposed, {:.3f} mm by world-space gradients",
                         to_name(law), 1e3 * unposed, 1e3 * world));
        REQUIRE(unposed < 1e-6);
        REQUIRE(world > 1e-3);
    }
}

TEST_CASE("On its way a driven tube lags behind and swings, unless it begins to move as the skinning does")
{
    const Template tube = test::tube_template(7, 8);
    const SoftBody tissue = test::soft_tube(tube, 8e3, 15e3);
    SoftTissueBody body(tissue, test::tube_poser(tube), {}, 1000);
    // All of it is moved at a constant speed.
    std::vector<Pose> poses;
    for (int n = 0; n < 25; ++n) {
        poses.push_back(Pose::rest(num_standard_joints));
        poses.back().root_translation << 0, 0, 0.01 * n;
    }
    DynamicsOptions options = tight();
    const auto lag = [&] {
        MotionSimulation simulation(body, poses, {}, options);
        double most = 0;
        std::optional<DynamicState> state;
        const DynamicBlock block = simulation.run(0, state);
        for (std::size_t f = 0; f < block.times.size(); ++f) {
            Points expected = tissue.rest;
            expected.col(2).array() += 1.2 * block.times[f];
            most = std::max(most, (frame_of(block, f) - expected).rowwise().norm().maxCoeff());
        }
        return most;
    };
    REQUIRE(lag() < 1e-6);  // frames are stored in single precision
    body.set_pose(body.pose(poses[0]));
    options.initial_velocity = InitialVelocity::zero;
    SoftTissueBody jerked(tissue, test::tube_poser(tube), {}, 1000);
    MotionSimulation simulation(jerked, poses, {}, options);
    const DynamicBlock block = simulation.run(0, std::nullopt);
    Points expected = tissue.rest;
    expected.col(2).array() += 1.2 * block.times[1];
    REQUIRE((frame_of(block, 1) - expected).rowwise().norm().maxCoeff() > 1e-3);
    REQUIRE(block.statistics.at("kinetic_energy_joule")[0] == 0);
    REQUIRE(block.statistics.at("potential_energy_joule")[1] > 1e-4);
}

TEST_CASE("Four times the weight moves saturating flesh less than four times as far, Neo-Hookean flesh farther")
{
    // The block hangs from the plane it is held at; its lower side is the skin.
    SoftBody tissue = test::soft_block({2, 2, 3}, {0.04, 0.04, 0.05}, 15e3, 15e3);
    tissue.rest.col(2).swap(tissue.rest.col(1));
    tissue.rest.col(1) *= -1;
    tissue.normals.col(2).setZero();
    tissue.normals.col(1).setConstant(-1);
    const auto sunk = [&](TissueLaw law, double mass) {
        TissueOptions law_options;
        law_options.law = law;
        SoftTissueBody body(tissue, test::still_poser(tissue.num_vertices()), law_options, 1000);
        SceneLoads loads;
        loads.loads.push_back({"weight", Eigen::Vector3d(0.02, -0.05, 0.02), "", 0.05, mass, 0});
        DynamicsOptions options;
        options.newton = {1e-7, 1e-8, 100};
        options.hold_seconds = 8;
        options.step_rate_hertz = 30;  // long steps damp more
        MotionSimulation simulation(body, {Pose::rest(num_standard_joints)}, loads, options);
        const DynamicState end = run_through(simulation);
        REQUIRE(end.velocities.norm() < 1e-3);
        return (tissue.rest - end.positions).col(1).tail(9).mean();
    };
    const double fung_light = sunk(TissueLaw::fung, 0.5), fung_heavy = sunk(TissueLaw::fung, 2);
    const double neo_light = sunk(TissueLaw::neo_hookean, 0.5), neo_heavy = sunk(TissueLaw::neo_hookean, 2);
    WARN(fmt::format("0.5 kg and 2 kg: Fung {:.1f} and {:.1f} mm, Neo-Hookean {:.1f} and {:.1f} mm", 1e3 * fung_light,
                     1e3 * fung_heavy, 1e3 * neo_light, 1e3 * neo_heavy));
    REQUIRE(fung_light > 1e-3);
    REQUIRE(fung_heavy > fung_light);
    REQUIRE(fung_heavy < 4 * fung_light);
    REQUIRE(neo_heavy > 4 * neo_light);
}

TEST_CASE("Loads hang on the skin within their radius, from their time on")
{
    const SoftBody tissue = test::soft_block({4, 4, 1}, {0.4, 0.4, 0.1}, 1e4, 1e4);
    SoftBodyPoser poser = test::still_poser(tissue.num_vertices());
    poser.joint_positions.row(3) << 0.4, 0.4, 0.1;
    const SoftTissueBody body(tissue, poser, {}, 1000);
    SceneLoads loads;
    loads.loads.push_back({"middle", Eigen::Vector3d(0.2, 0.2, 0.1), "", 0.12, 2, 0.5});
    loads.loads.push_back({"corner", std::nullopt, poser.skeleton.joint_names[3], 0.01, 3, 1});
    Eigen::VectorXd masses;
    Points forces;
    const LoadSchedule schedule(loads, body);
    schedule.at(0.4, masses, forces);
    REQUIRE(masses.sum() == 0);
    REQUIRE(forces.norm() == 0);
    schedule.at(0.5, masses, forces);
    REQUIRE(masses.sum() == Approx(2));
    REQUIRE(forces.col(1).sum() == Approx(-2 * 9.81));
    REQUIRE((masses.array() > 0).count() == 5);
    REQUIRE(masses.head(25).sum() == 0);  // held
    schedule.at(2, masses, forces);
    REQUIRE(masses.sum() == Approx(5));
    REQUIRE(masses.tail(1)[0] == Approx(3));
    loads.gravity = true;
    LoadSchedule(loads, body).at(0, masses, forces);
    REQUIRE(masses.sum() == 0);
    REQUIRE(forces.col(1).sum() == Approx(-9.81 * 16));

    loads.loads[0].center = Eigen::Vector3d(0.2, 0.2, 5);
    REQUIRE_THROWS_WITH(LoadSchedule(loads, body), Catch::Contains("load \"middle\": no skin"));
    loads.loads[0].center.reset();
    loads.loads[0].joint = "tail";
    REQUIRE_THROWS_WITH(LoadSchedule(loads, body), Catch::Contains("there is no joint \"tail\""));
}

TEST_CASE("A layered body with inertia comes to the equilibrium of its static simulation")
{
    const Template tube = test::tube_template(7, 8);
    SimulationOptions simulation_options;
    simulation_options.posing = test::bending;
    simulation_options.newton.relative_tolerance = 1e-9;
    LayeredDrivenBody body(tube, tube.rest, simulation_options, 1000);
    REQUIRE(body.masses().sum() > 1);
    DynamicsOptions options = tight();
    options.newton.relative_tolerance = 1e-9;
    options.hold_seconds = 3;
    MotionSimulation simulation(body, bend(0.6, 24), {}, options);
    const DynamicState end = run_through(simulation);
    const Points expected = body.equilibrium(test::tube_pose(0.6));
    const double error = (end.positions - expected).rowwise().norm().maxCoeff();
    WARN(fmt::format("layered tube: {:.2e} mm from its static equilibrium", 1e3 * error));
    REQUIRE(error < 1e-5);
    REQUIRE((expected - tube.rest.volume_vertices).norm() > 0.1);
}

TEST_CASE("Vertices are carried along with what is about them, also where skinning collapses")
{
    Points rest(2, 3), positions(2, 3);
    rest << 1, 0, 0, 0, 1, 0;
    positions << 1.1, 0, 0, 0, 1.2, 0;
    AffineMap turned = AffineMap::Zero(), flat = AffineMap::Zero();
    turned.leftCols<3>() = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    turned.col(3) << 5, 0, 0;
    flat(0, 0) = 1;
    const Points moved = carry_along({AffineMap::Identity(), flat}, {turned, turned}, rest, positions);
    REQUIRE((moved.row(0) - Eigen::RowVector3d(5, 1.1, 0)).norm() < 1e-14);
    REQUIRE((moved.row(1) - Eigen::RowVector3d(4, 1.2, 0)).norm() < 1e-14);
}

TEST_CASE("Rates that do not divide, and motions without poses, are refused")
{
    DynamicsOptions options;
    options.frame_rate_hertz = 50;
    REQUIRE_THROWS_AS(options.steps_per_frame(), InputError);
    options.frame_rate_hertz = 240;
    REQUIRE_THROWS_AS(options.steps_per_frame(), InputError);
    options.frame_rate_hertz = 40;
    REQUIRE(options.steps_per_frame() == 3);
    const SoftBody tissue = test::soft_block({1, 1, 2}, {0.1, 0.1, 0.1}, 1e4, 1e4);
    SoftTissueBody body(tissue, test::still_poser(tissue.num_vertices()), {}, 1000);
    REQUIRE_THROWS_AS(MotionSimulation(body, {}, {}, options), InputError);
    REQUIRE(test::undescribed_bytes<DynamicsOptions>().empty());
    REQUIRE(test::undescribed_bytes<TissueOptions>().empty());
}
