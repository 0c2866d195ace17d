// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/dynamics/point_terms.h"
#include "ndg/elastic/objective.h"

#include <catch2/catch.hpp>

using namespace ndg;

TEST_CASE("Inertia and loads: energies in closed form, derivatives")
{
    Random random(1, "points");
    const auto random_points = [&] {
        Points x(5, 3);
        for (int k = 0; k < 15; ++k) x.data()[k] = random.normal();
        return x;
    };
    ElasticBody body(5, 1);
    auto made_inertia = std::make_unique<InertiaTerm>(5);
    auto made_loads = std::make_unique<LoadTerm>(5);
    InertiaTerm& inertia = *made_inertia;
    LoadTerm& loads = *made_loads;
    body.add(std::move(made_inertia));
    body.add(std::move(made_loads));
    const Objective objective(body);
    Eigen::VectorXd masses(5);
    masses << 100, 1, 2, 3, 4;
    const Points inertial = random_points(), forces = random_points(), origins = random_points(), x = random_points();
    inertia.set_step(masses, inertial, 0.1);
    loads.set_forces(forces, origins);
    double expected = 0;  // the first vertex is fixed
    for (int v = 1; v < 5; ++v) {
        expected += masses[v] / 0.02 * (x.row(v) - inertial.row(v)).squaredNorm();
        expected -= forces.row(v).dot(x.row(v) - origins.row(v));
    }
    REQUIRE(objective.energy(x) == Approx(expected).epsilon(1e-12));

    Eigen::VectorXd gradient, absolute;
    objective.gradient(x, gradient, absolute);
    Eigen::SparseMatrix<double> hessian = objective.hessian_pattern();
    objective.hessian(x, HessianKind::exact, hessian);
    for (int d = 0; d < 12; ++d) {
        Points plus = x, minus = x;
        plus(1 + d / 3, d % 3) += 1e-5;
        minus(1 + d / 3, d % 3) -= 1e-5;
        REQUIRE(gradient[d] == Approx((objective.energy(plus) - objective.energy(minus)) / 2e-5).epsilon(1e-6));
        Eigen::VectorXd above, below;
        objective.gradient(plus, above, absolute);
        objective.gradient(minus, below, absolute);
        const Eigen::VectorXd numeric = (above - below) / 2e-5;
        for (int row = d; row < 12; ++row) {
            REQUIRE(hessian.coeff(row, d) == Approx(numeric[row]).epsilon(1e-6).margin(1e-5));
        }
        REQUIRE(hessian.coeff(d, d) == Approx(100 * masses[1 + d / 3]));
    }
    REQUIRE_THROWS_AS(inertia.set_step(masses.head(4), inertial, 0.1), Error);
    REQUIRE_THROWS_AS(loads.set_forces(forces.topRows(4), origins), Error);
}
