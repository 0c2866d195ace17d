// SPDX-License-Identifier: Apache-2.0
// The method itself: order, energy, momentum, what it refuses.
#include "soft_shapes.h"

#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/dynamics/implicit_euler.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;

namespace {

ImplicitEulerOptions exact_options(double time_step)
{
    ImplicitEulerOptions options;
    options.time_step_seconds = time_step;
    options.newton.relative_tolerance = 1e-12;
    options.newton.absolute_tolerance_newton = 1e-11;
    return options;
}

/// A block of soft tissue; `num_held` -1: its lower side.
struct Moving {
    SoftBody tissue = test::soft_block({2, 2, 3}, {0.04, 0.04, 0.06}, 6e3, 15e3);
    std::unique_ptr<ElasticBody> elastic;
    std::unique_ptr<ImplicitEuler> euler;
    Eigen::VectorXd masses;
    DynamicState state;

    explicit Moving(const ImplicitEulerOptions& options, int num_held = -1,
                    DeformationSpace space = DeformationSpace::world)
    {
        if (num_held >= 0) tissue.num_held = num_held;
        tissue.check();
        TissueOptions law;
        law.space = space;
        elastic = std::make_unique<ElasticBody>(tissue.num_vertices(), tissue.num_held);
        elastic->add(tissue_term(tissue, law, tissue.num_vertices()).term);
        elastic->set_rest(tissue.rest);
        masses = lumped_masses(tissue.rest, tissue.tetrahedra, 1000);
        euler = std::make_unique<ImplicitEuler>(*elastic, masses, options);
        state = {tissue.rest, Points::Zero(tissue.num_vertices(), 3)};
    }
    /// A push aside that grows with height.
    void push(double speed)
    {
        state.velocities.col(0) = speed * tissue.rest.col(2) / 0.06;
        state.velocities.topRows(tissue.num_held).setZero();
    }
    NewtonResult step()
    {
        Points start = state.positions;
        if (tissue.num_held == 0) start += euler->options().time_step_seconds * state.velocities;
        return euler->step(state, start);
    }
    double total() { return euler->kinetic_energy(state) + euler->potential_energy(state.positions); }
    Eigen::RowVector3d momentum() const { return masses.transpose() * state.velocities; }
    Eigen::RowVector3d angular_momentum() const
    {
        Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
        for (Eigen::Index v = 0; v < masses.size(); ++v) {
            sum += masses[v] * state.positions.row(v).cross(state.velocities.row(v));
        }
        return sum;
    }
};

}  // namespace

TEST_CASE("Masses are those of the volume, at any density")
{
    const SoftBody block = test::soft_block({2, 3, 2}, {0.1, 0.2, 0.05}, 1e4, 1e4);
    const Eigen::VectorXd masses = lumped_masses(block.rest, block.tetrahedra, 900);
    REQUIRE(masses.sum() == Approx(0.9));
    REQUIRE((masses.array() > 0).all());
}

TEST_CASE("A vertex that falls freely, and a spring in closed form")
{
    // One tetrahedron's mass without stiffness to speak of falls as implicit Euler's method falls.
    const double h = 0.01;
    ElasticBody body(1, 0);
    ImplicitEuler euler(body, Eigen::VectorXd::Constant(1, 2.0), exact_options(h));
    Points force(1, 3);
    force << 0, -2 * 9.81, 0;
    euler.set_loads(Eigen::VectorXd::Zero(1), force);
    DynamicState state{Points::Zero(1, 3), Points::Zero(1, 3)};
    state.velocities(0, 0) = 3;
    for (int n = 1; n <= 20; ++n) {
        REQUIRE(euler.step(state, state.positions).converged());
        REQUIRE(state.positions(0, 0) == Approx(3 * h * n));
        REQUIRE(state.positions(0, 1) == Approx(-9.81 * h * h * n * (n + 1) / 2));
        REQUIRE(state.velocities(0, 1) == Approx(-9.81 * h * n));
    }
    REQUIRE(euler.kinetic_energy(state) == Approx(9 + std::pow(9.81 * 0.2, 2)));
    // Mass that is hung on moves along: no jump of the velocity, and it falls as before.
    euler.set_loads(Eigen::VectorXd::Constant(1, 1.0), 1.5 * force);
    euler.step(state, state.positions);
    REQUIRE(state.velocities(0, 1) == Approx(-9.81 * h * 21));
}

TEST_CASE("Halving the time step halves the error")
{
    const auto tip = [](int steps) {
        constexpr double seconds = 0.04;
        Moving block(exact_options(seconds / steps));
        block.push(0.6);
        for (int n = 0; n < steps; ++n) REQUIRE(block.step().converged());
        return Eigen::RowVector3d(block.state.positions.bottomRows<1>());
    };
    const Eigen::RowVector3d fine = 2 * tip(512) - tip(256);  // extrapolated
    double last = 0;
    for (const int steps : {16, 32, 64, 128}) {
        const double error = (tip(steps) - fine).norm();
        CAPTURE(steps, error, last);
        REQUIRE(error > 1e-6);
        if (last > 0) {
            REQUIRE(last / error > 1.6);
            REQUIRE(last / error < 2.4);
        }
        last = error;
    }
}

TEST_CASE("Without anything that moves it the energy decays to rest")
{
    for (const DeformationSpace space : {DeformationSpace::world, DeformationSpace::unposed}) {
        Moving block(exact_options(1.0 / 120), -1, space);
        block.push(1.0);
        const double start = block.total();
        REQUIRE(start > 1e-3);
        double last = start;
        for (int n = 0; n < 360; ++n) {
            REQUIRE(block.step().converged());
            const double now = block.total();
            REQUIRE(now < last + 1e-12 * start);
            last = now;
        }
        REQUIRE(last < 1e-6 * start);
        REQUIRE((block.state.positions - block.tissue.rest).rowwise().norm().maxCoeff() < 1e-4);
    }
}

TEST_CASE("A body that nothing holds keeps its momentum, and its angular momentum as far as the method goes")
{
    const auto lost = [](double time_step, int steps) {
        Moving block(exact_options(time_step), 0);
        Random random(5, "momentum");
        const Eigen::RowVector3d middle = block.tissue.rest.colwise().mean();
        for (Eigen::Index v = 0; v < block.masses.size(); ++v) {
            const Eigen::RowVector3d arm = block.tissue.rest.row(v) - middle;
            block.state.velocities.row(v) =
                Eigen::RowVector3d(0.3, -0.2, 0.5) + Eigen::RowVector3d(2, 6, -3).cross(arm);
            block.state.velocities(v, 0) += 5 * arm[2];  // and not as a rigid body
        }
        const Eigen::RowVector3d momentum = block.momentum(), start = block.angular_momentum();
        for (int n = 0; n < steps; ++n) {
            const DynamicState before = block.state;
            const Eigen::RowVector3d turning = block.angular_momentum();
            REQUIRE(block.step().converged());
            REQUIRE((block.momentum() - momentum).norm() < 1e-9 * momentum.norm());
            // sum x_1 x m (v_1 - v_0) vanishes with the moment of all forces: what is left is h sum m v_1 x v_0.
            Eigen::RowVector3d expected = turning;
            for (Eigen::Index v = 0; v < block.masses.size(); ++v) {
                expected += time_step * block.masses[v] * block.state.velocities.row(v).cross(before.velocities.row(v));
            }
            REQUIRE((block.angular_momentum() - expected).norm() < 1e-9 * start.norm());
        }
        return (block.angular_momentum() - start).norm() / start.norm();
    };
    const double coarse = lost(1e-3, 40), fine = lost(5e-4, 80);
    CAPTURE(coarse, fine);
    REQUIRE(coarse < 0.1);
    REQUIRE(fine < 0.65 * coarse);
}

TEST_CASE("The factor of the last step saves factorisations and changes nothing but rounding")
{
    ImplicitEulerOptions options = exact_options(1.0 / 120);
    options.newton.relative_tolerance = 1e-9;
    Moving with(options);
    options.keep_factor = false;
    Moving without(options);
    with.push(0.3);
    without.push(0.3);
    int kept = 0, anew = 0;
    for (int n = 0; n < 20; ++n) {
        const NewtonResult a = with.step(), b = without.step();
        REQUIRE(a.converged());
        REQUIRE(b.converged());
        kept += a.factorizations;
        anew += b.factorizations;
        REQUIRE((with.state.positions - without.state.positions).norm() < 1e-7);
    }
    CAPTURE(kept, anew);
    REQUIRE(kept < anew / 2);
}

TEST_CASE("What does not fit is refused in one sentence")
{
    Moving block(exact_options(0.01));
    const Eigen::Index count = block.tissue.num_vertices();
    Points start = block.state.positions;
    start(20, 1) = std::nan("");
    REQUIRE_THROWS_WITH(block.euler->step(block.state, start, 0.25), Catch::Contains("not finite at 0.25 s"));
    REQUIRE_THROWS_AS(block.euler->step(block.state, start.topRows(3)), Error);
    REQUIRE_THROWS_AS(block.euler->set_loads(Eigen::VectorXd::Zero(3), Points::Zero(count, 3)), Error);
    REQUIRE_THROWS_AS(block.euler->set_loads(Eigen::VectorXd::Constant(count, -1), Points::Zero(count, 3)), Error);
    // Stretched beyond what the exponential bears.
    start = 20 * block.tissue.rest;
    REQUIRE_THROWS_WITH(block.euler->step(block.state, start, 0.5), Catch::Contains("energy is not finite"));
    REQUIRE_THROWS_WITH(ImplicitEuler(*block.elastic, block.masses, {}), Catch::Contains("two integrators"));
    ElasticBody body(4, 1);
    Eigen::VectorXd masses(4);
    masses << 0, 1, 0, 1;
    REQUIRE_THROWS_WITH(ImplicitEuler(body, masses, {}), Catch::Contains("vertex 2 is free and has a mass of 0 kg"));
    REQUIRE_THROWS_AS(ImplicitEuler(body, masses.head(3), {}), Error);
}

TEST_CASE("Soft bodies with wrong counts or values are refused by name")
{
    const SoftBody good = test::soft_block({1, 1, 2}, {0.1, 0.1, 0.1}, 1e4, 1e4);
    REQUIRE_NOTHROW(good.check());
    const auto refused = [&](const auto& spoil, const char* words) {
        SoftBody bad = good;
        spoil(bad);
        REQUIRE_THROWS_WITH(bad.check(), Catch::Contains("block: ") && Catch::Contains(words));
        REQUIRE_THROWS_AS(bad.check(), InputError);
    };
    refused([](SoftBody& b) { b.rest(3, 1) = std::nan(""); }, "vertex 3 is not finite");
    refused([](SoftBody& b) { b.normals.conservativeResize(5, 3); }, "5 of normals");
    refused([](SoftBody& b) { b.young_tangent_pascal.conservativeResize(5); }, "5 of moduli along the skin");
    refused([](SoftBody& b) { b.young_normal_pascal[2] = 0; }, "vertex 2 has a Young's modulus of 0 Pa");
    refused([](SoftBody& b) { b.num_held = 12; }, "12 held of 12");
    refused([](SoftBody& b) { b.tetrahedra(1, 2) = 12; }, "vertex 12 of 12");
    refused([](SoftBody& b) { b.tetrahedra(3, 0) = b.tetrahedra(3, 1); }, "tetrahedron 3 has a volume of 0 m^3");
    refused([](SoftBody& b) { b.normals.setZero(); }, "the normals of tetrahedron 0 cancel");
    refused([](SoftBody& b) { b.skin_triangles(0, 0) = -1; }, "the skin has vertices");
    SoftBody bad = good;
    bad.tetrahedra.conservativeResize(6, 4);
    REQUIRE_THROWS_WITH(bad.check(), Catch::Contains("free vertex 8 belongs to no tetrahedron"));
}
