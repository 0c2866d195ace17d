// SPDX-License-Identifier: Apache-2.0
// Energies, forces and Hessians of whole bodies and of parts of them.
#include "derivatives.h"

#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/elastic/layered_body.h"
#include "ndg/elastic/objective.h"
#include "ndg/elastic/volume_guard.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <Eigen/Eigenvalues>

using namespace ndg;
using test::hessian_of;
using test::require_derivatives;

namespace {

Points jittered(Points points, int first, double spread)
{
    Random random(11, "jitter");
    for (Eigen::Index v = first; v < points.rows(); ++v) {
        for (int c = 0; c < 3; ++c) points(v, c) += spread * random.uniform(-1, 1);
    }
    return points;
}

double smallest_eigenvalue(const Eigen::MatrixXd& matrix)
{
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix, Eigen::EigenvaluesOnly).eigenvalues()(0);
}

MaterialOptions material(const std::string& energy)
{
    MaterialOptions options;
    options.energy = parse_name<FleshEnergy>(energy);
    return options;
}

}  // namespace

TEST_CASE("Assembled gradient and Hessian are derivatives of the energy")
{
    const Template tube = test::tube_template(3, 5);
    const ElasticBody elastic = layered_body(tube, material("paper"));
    const Objective objective(elastic);
    const Points x = jittered(tube.rest.volume_vertices, tube.num_wrap_vertices(), 0.004);
    require_derivatives(objective, x);
    const Eigen::MatrixXd exact = hessian_of(objective, x, HessianKind::exact);
    REQUIRE(smallest_eigenvalue(exact) < 0);
    for (const HessianKind kind : {HessianKind::projected, HessianKind::gauss_newton}) {
        REQUIRE(smallest_eigenvalue(hessian_of(objective, x, kind)) > -1e-9 * exact.norm());
    }
    const double nearly = smallest_eigenvalue(hessian_of(objective, x, HessianKind::nearly_exact));
    REQUIRE(nearly > smallest_eigenvalue(exact));
}

TEST_CASE("Elements in order are left as they are by the nearly exact Hessian")
{
    const Template tube = test::tube_template(3, 5);
    const ElasticBody elastic = layered_body(tube, material("paper"));
    const Objective objective(elastic);
    const Points x = jittered(tube.rest.volume_vertices, tube.num_wrap_vertices(), 1e-5);
    const Eigen::MatrixXd exact = hessian_of(objective, x, HessianKind::exact);
    REQUIRE((hessian_of(objective, x, HessianKind::nearly_exact) - exact).norm() < 1e-14 * exact.norm());
    REQUIRE((hessian_of(objective, x, HessianKind::projected) - exact).norm() > 1e-9 * exact.norm());
}

TEST_CASE("The guarded energy sees flat and inverted prisms, with its derivatives")
{
    const Template tube = test::tube_template(3, 5);
    const ElasticBody paper = layered_body(tube, material("paper"));
    const ElasticBody guarded = layered_body(tube, material("inversion-free"));
    const Objective paper_objective(paper), objective(guarded);
    const Points& rest = tube.rest.volume_vertices;
    // Far from flat both are one.
    const Points mild = jittered(rest, tube.num_wrap_vertices(), 0.004);
    REQUIRE(objective.energy(mild) == Approx(paper_objective.energy(mild)).epsilon(1e-14));
    // Muscle wrap and skin pressed towards the bone wrap, some prisms through it.
    Points pressed = jittered(rest, tube.num_wrap_vertices(), 0.003);
    const int wrap = tube.num_wrap_vertices();
    for (int v = 0; v < wrap; ++v) {
        pressed.row(wrap + v) += (v % 3 == 0 ? 1.1 : 0.9) * (rest.row(v) - rest.row(wrap + v));
    }
    REQUIRE((prism_volumes(pressed, tube.prisms).array() < 0).any());
    const double lambda[2] = {lame_parameters(45e3, 0.47).lambda, lame_parameters(15e3, 0.47).lambda};
    double expected = 0;
    for (int p = 0; p < tube.num_prisms(); ++p) {
        const double volume = prism_volume(gather_prism(rest, tube.prisms, p));
        const double share = prism_volume(gather_prism(pressed, tube.prisms, p)) / volume;
        double guard = volume_guard(share).energy;
        // Corners by six times the volume of a tetrahedron: the vertex, the next two of its triangle, the one across.
        for (int a = 0; a < 6; ++a) {
            const int row = a < 3 ? 0 : 3;
            const auto jacobian = [&](const Points& x) {
                const auto at = [&](int corner) -> Eigen::Vector3d {
                    return x.row(tube.prisms(p, corner)).transpose();
                };
                const Eigen::Vector3d across = a < 3 ? at(a) - at(a + 3) : at(a - 3) - at(a);
                const Eigen::Vector3d next = at(row + (a + 1) % 3) - at(a), last = at(row + (a + 2) % 3) - at(a);
                return next.cross(last).dot(across);
            };
            guard += corner_guard(jacobian(pressed) / jacobian(rest)).energy / 6;
        }
        expected += lambda[p >= tube.fat_begin()] * volume * guard;
    }
    REQUIRE(expected > 1);
    REQUIRE(objective.energy(pressed) - paper_objective.energy(pressed) == Approx(expected));
    require_derivatives(objective, pressed);
    REQUIRE(smallest_eigenvalue(hessian_of(objective, pressed, HessianKind::projected)) > -1e-6);

    for (const double share : {-0.5, 0.0, 0.1, 0.2, 0.2499}) {
        const double step = 1e-6;
        const VolumeGuard here = volume_guard(share), high = volume_guard(share + step),
                          low = volume_guard(share - step);
        REQUIRE(here.energy > 0);
        REQUIRE(here.first == Approx((high.energy - low.energy) / (2 * step)).epsilon(1e-4).margin(1e-6));
        REQUIRE(here.second == Approx((high.first - low.first) / (2 * step)).epsilon(1e-4).margin(1e-3));
    }
    REQUIRE(volume_guard(guarded_volume_share).energy == 0);
}

TEST_CASE("A part of the body has the forces and Hessian of the whole at its vertices")
{
    const Template tube = test::tube_template(4, 6);
    const ElasticBody elastic = layered_body(tube, material("paper"));
    const Objective whole(elastic);
    const int first = tube.num_wrap_vertices();
    const std::vector<int> vertices{first + 3, first + 4, first + 9, first + 27, first + 28, first + 34};
    const Objective part(elastic, vertices);
    const Points x = jittered(tube.rest.volume_vertices, first, 0.004);
    Eigen::VectorXd all, some, scratch;
    whole.gradient(x, all, scratch);
    part.gradient(x, some, scratch);
    REQUIRE(some.size() == 18);
    std::vector<int> unknowns;
    for (const int v : vertices) {
        for (int c = 0; c < 3; ++c) unknowns.push_back(3 * (v - first) + c);
    }
    REQUIRE((some - all(unknowns)).norm() < 1e-12 * all.norm());
    for (const HessianKind kind : {HessianKind::exact, HessianKind::projected}) {
        const Eigen::MatrixXd full = hessian_of(whole, x, kind);
        REQUIRE((hessian_of(part, x, kind) - full(unknowns, unknowns)).norm() < 1e-12 * full.norm());
    }
    require_derivatives(part, x);
    Points moved = x;
    moved.row(vertices[1]) += Eigen::RowVector3d(0.002, -0.001, 0.003);
    REQUIRE(part.energy(moved) - part.energy(x) == Approx(whole.energy(moved) - whole.energy(x)));

    REQUIRE_THROWS_AS(Objective(elastic, std::vector<int>{first - 1}), Error);
    REQUIRE_THROWS_AS(Objective(elastic, std::vector<int>{first + 2, first + 1}), Error);
}
