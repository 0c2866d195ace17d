// SPDX-License-Identifier: Apache-2.0
// Assembled blocks of prisms in states whose energy and stress have a closed form. The material as published,
// psi = mu/2 (|F|^2 - 3) + lambda/2 (J - alpha)^2 + const with alpha = 1 + mu/lambda, has at rest the Lame parameters
// mu and lambda - mu, so that Young's modulus is mu (3 - mu/lambda) and Poisson's ratio (1 - mu/lambda) / 2 there.
#include "ndg/elastic/layered_body.h"
#include "ndg/elastic/objective.h"
#include "ndg/simulation/newton.h"
#include "verification_bodies.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Makes a layer of flesh next to nothing.
constexpr double no_stiffness = 1e-8;

struct State {
    std::string name;
    Matrix3d deformation;
    Matrix3d stress;    ///< first Piola-Kirchhoff, Pa
    double energy = 0;  ///< J/m^3
};

/// Cross section of a bar pulled to s times its length: the side's stress mu t + (lambda (s t^2 - 1) - mu) s t is zero.
double contraction(double s, const Lame& lame)
{
    return std::sqrt((1 + lame.mu / lame.lambda * (1 - 1 / s)) / s);
}

std::vector<State> closed_forms(const Lame& lame)
{
    const double mu = lame.mu, lambda = lame.lambda;
    std::vector<State> states;
    for (const double s : {0.8, 1.25}) {
        // Oedometer: the sides stay. Along the axis the material is linear.
        State oedometer{"uniaxial strain", Matrix3d::Identity(), Matrix3d::Zero(), 0};
        oedometer.deformation(2, 2) = s;
        oedometer.stress.diagonal() << s * (lambda * (s - 1) - mu) + mu, s * (lambda * (s - 1) - mu) + mu,
            (lambda + mu) * (s - 1);
        oedometer.energy = 0.5 * (lambda + mu) * (s - 1) * (s - 1);
        states.push_back(oedometer);

        const double t = contraction(s, lame), volume = s * t * t;
        State uniaxial{"uniaxial stress", Vector3d(t, t, s).asDiagonal(), Matrix3d::Zero(), 0};
        uniaxial.stress(2, 2) = mu * (s - t * t / s);
        uniaxial.energy =
            0.5 * mu * (s * s + 2 * t * t - 3) - mu * (volume - 1) + 0.5 * lambda * (volume - 1) * (volume - 1);
        states.push_back(uniaxial);

        const double ball = s * s * s;
        State hydrostatic{"hydrostatic", s * Matrix3d::Identity(), Matrix3d::Identity(), 0};
        hydrostatic.stress *= mu * s + (lambda * (ball - 1) - mu) * s * s;
        hydrostatic.energy = 1.5 * mu * (s * s - 1) - mu * (ball - 1) + 0.5 * lambda * (ball - 1) * (ball - 1);
        states.push_back(hydrostatic);
    }
    for (const double g : {-0.3, 0.7}) {
        // The volume stays, and of this stress there are no normal parts.
        State shear{"simple shear", Matrix3d::Identity(), Matrix3d::Zero(), 0.5 * mu * g * g};
        shear.deformation(0, 2) = g;
        shear.stress(0, 2) = shear.stress(2, 0) = mu * g;
        states.push_back(shear);
        State across{"simple shear of the plane", Matrix3d::Identity(), Matrix3d::Zero(), 0.5 * mu * g * g};
        across.deformation(0, 1) = g;
        across.stress(0, 1) = across.stress(1, 0) = mu * g;
        states.push_back(across);
    }
    return states;
}

Points deformed(const Template& body, const Matrix3d& deformation)
{
    return body.rest.volume_vertices * deformation.transpose();
}

/// Force that holds the vertices of a part of the block; forces are those of `objective` on all free vertices.
template <class Condition>
Vector3d total_force(const test::Block& block, const Objective& objective, const Eigen::VectorXd& forces,
                     const Condition& condition)
{
    Vector3d sum = Vector3d::Zero();
    for (int k = 1; k <= block.cells(2); ++k) {
        for (int i = 0; i <= block.cells(0); ++i) {
            for (int j = 0; j <= block.cells(1); ++j) {
                if (!condition(i, j, k)) continue;
                sum += forces.segment<3>(3 * (block.vertex(i, j, k) - objective.vertices().front()));
            }
        }
    }
    return sum;
}

void require_force(const Vector3d& force, const Vector3d& expected, double scale)
{
    REQUIRE(scale > 0);
    REQUIRE((force - expected).norm() < 1e-9 * scale);
}

}  // namespace

TEST_CASE("A slab of muscle and fat in closed-form states: energy, and the force on its skin")
{
    test::Block block;
    block.unevenness = 0.3;
    const Template body = block.body();
    const MaterialOptions material = test::bare_flesh(45e3, 15e3, 0.47);
    const ElasticBody elastic = layered_body(body, material);
    const Objective objective(elastic);
    const double area = block.size(0) * block.size(1), thickness = 0.5 * block.size(2);
    const Lame muscle = lame_parameters(45e3, 0.47), fat = lame_parameters(15e3, 0.47);
    // Both layers in one state: with one ratio mu / lambda its deformation is the same for both.
    const std::vector<State> in_muscle = closed_forms(muscle), in_fat = closed_forms(fat);
    for (std::size_t i = 0; i < in_fat.size(); ++i) {
        CAPTURE(in_fat[i].name);
        const Points x = deformed(body, in_fat[i].deformation);
        REQUIRE(objective.energy(x) ==
                Approx(area * thickness * (in_muscle[i].energy + in_fat[i].energy)).epsilon(1e-10));
        Eigen::VectorXd forces, absolute;
        objective.gradient(x, forces, absolute);
        const auto skin = [&](int, int, int k) { return k == 2; };
        const auto interface = [&](int, int, int k) { return k == 1; };
        const double scale = area * in_fat[i].stress.norm();
        require_force(total_force(block, objective, forces, skin), area * in_fat[i].stress.col(2), scale);
        // What the muscle pulls down is three times what the fat pulls up.
        require_force(total_force(block, objective, forces, interface),
                      area * (in_muscle[i].stress.col(2) - in_fat[i].stress.col(2)), scale);
    }
}

TEST_CASE("A free block in closed-form states: every face carries the stress, its inside nothing")
{
    test::Block block;
    block.cells << 5, 4, 2;
    block.size << 0.11, 0.09, 0.06;
    block.unevenness = 0.3;
    const Template body = block.body();
    // Fat alone, between muscle wrap and skin: all its vertices are free.
    const ElasticBody elastic = layered_body(body, test::bare_flesh(no_stiffness, 15e3, 0.47));
    const Objective objective(elastic);
    const double height = 0.5 * block.size(2);
    const Vector3d face_areas(block.size(1) * height, block.size(0) * height, block.size(0) * block.size(1));
    for (const State& state : closed_forms(lame_parameters(15e3, 0.47))) {
        CAPTURE(state.name);
        const Points x = deformed(body, state.deformation);
        Eigen::VectorXd forces, absolute;
        objective.gradient(x, forces, absolute);
        for (int axis = 0; axis < 3; ++axis) {
            const auto high = [&](int i, int j, int k) { return Eigen::Array3i(i, j, k)(axis) == block.cells(axis); };
            const auto low = [&](int i, int j, int k) { return Eigen::Array3i(i, j, k)(axis) == (axis == 2 ? 1 : 0); };
            const Vector3d traction = face_areas(axis) * state.stress.col(axis);
            require_force(total_force(block, objective, forces, high), traction,
                          face_areas(axis) * state.stress.norm());
            require_force(total_force(block, objective, forces, low), -traction,
                          face_areas(axis) * state.stress.norm());
        }
        // The mean stress: forces times arms, over the volume.
        Matrix3d virial = Matrix3d::Zero();
        for (int v = objective.vertices().front(); v < elastic.num_vertices(); ++v) {
            virial += forces.segment<3>(3 * (v - objective.vertices().front())) * body.rest.volume_vertices.row(v);
        }
        REQUIRE((virial / (face_areas(2) * height) - state.stress).norm() < 1e-9 * state.stress.norm());
    }
}

TEST_CASE("A bar held at its ends contracts and pulls as in closed form; at small strains with the expected moduli")
{
    test::Block block;
    block.cells << 8, 3, 2;
    block.size << 0.12, 0.04, 0.05;
    block.unevenness = 0.2;
    const Template body = block.body();
    const Lame lame = lame_parameters(15e3, 0.47);
    const ElasticBody elastic = layered_body(body, test::bare_flesh(no_stiffness, 15e3, 0.47));
    const Objective all(elastic);
    std::vector<int> inside;
    for (int k = 1; k <= 2; ++k) {
        for (int i = 1; i < block.cells(0); ++i) {
            for (int j = 0; j <= block.cells(1); ++j) inside.push_back(block.vertex(i, j, k));
        }
    }
    const Objective objective(elastic, inside);
    NewtonSolver solver(objective);
    NewtonOptions options;
    options.relative_tolerance = 1e-12;
    options.absolute_tolerance_newton = 0;
    const double end_area = block.size(1) * 0.5 * block.size(2);
    // Pulled only: one layer of prisms, whose gradients are averaged over the thickness, buckles when pressed.
    for (const double s : {1.0005, 1.1, 1.3}) {
        CAPTURE(s);
        const double t = contraction(s, lame);
        const Points expected = deformed(body, Vector3d(s, t, t).asDiagonal());
        Points x = expected;
        // The inside starts without the contraction that it has to find.
        for (const int v : inside) {
            x.row(v) = body.rest.volume_vertices.row(v) * Vector3d(s, 1, 1).asDiagonal();
        }
        const double start = (x - expected).rowwise().norm().maxCoeff();
        const NewtonResult result = solver.minimise(x, options);
        CAPTURE(describe(result.stop), result.residual_relative, result.iterations);
        REQUIRE(result.residual_relative < 1e-9);
        REQUIRE((x - expected).rowwise().norm().maxCoeff() < 1e-5 * start);
        Eigen::VectorXd forces, absolute;
        all.gradient(x, forces, absolute);
        const auto end = [&](int i, int, int) { return i == block.cells(0); };
        const Vector3d pull = total_force(block, all, forces, end);
        REQUIRE(pull.x() == Approx(end_area * lame.mu * (s - t * t / s)).epsilon(1e-6));
        if (std::abs(s - 1) > 1e-3) continue;

        const double young = pull.x() / (end_area * (s - 1));
        const int side = block.vertex(4, block.cells(1), 2), across = block.vertex(4, 0, 2);
        const double width = x(side, 1) - x(across, 1);
        const double poisson = (1 - width / block.size(1)) / (s - 1);
        REQUIRE(young == Approx(lame.mu * (3 - lame.mu / lame.lambda)).epsilon(1e-3));
        REQUIRE(poisson == Approx(0.5 * (1 - lame.mu / lame.lambda)).epsilon(2e-3));
        // With Poisson's ratio of 0.47 that is nearly what the parameters are named after.
        REQUIRE(young == Approx(15e3).epsilon(3e-3));
        REQUIRE(poisson == Approx(0.47).epsilon(6e-3));
    }
}
