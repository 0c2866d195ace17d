// SPDX-License-Identifier: Apache-2.0
// The barrier between parts of the skin, its derivatives and where it acts.
#include "derivatives.h"

#include "ndg/core/random.h"
#include "ndg/elastic/contact_barrier.h"
#include "ndg/elastic/contact_term.h"
#include "ndg/elastic/elastic_body.h"

#include <catch2/catch.hpp>

#include <Eigen/Eigenvalues>

#include <cmath>

using namespace ndg;
using test::hessian_of;
using test::require_derivatives;

namespace {

/// Two triangles above each other, edge length about 1 cm, `gap` apart, turned against each other by 0.4.
struct Sheets {
    Points rest{6, 3};
    Triangles triangles{2, 3};
    ContactTerm* term;
    ElasticBody body{6, 0};

    explicit Sheets(double stiffness = 5e3)
    {
        triangles << 0, 1, 2, 3, 5, 4;
        rest = apart(1.0);
        ContactOptions options;
        options.contact = true;
        options.contact_stiffness_pascal = stiffness;
        auto owned = std::make_unique<ContactTerm>(triangles, options, 6);
        term = owned.get();
        body.add(std::move(owned));
        body.set_rest(rest);
    }
    static Points apart(double gap)
    {
        Points x(6, 3);
        for (int v = 0; v < 6; ++v) {
            const double angle = 2.0943951 * (v % 3) + (v < 3 ? 0 : 0.4);
            x.row(v) << 0.006 * std::cos(angle), v < 3 ? 0.0003 * v : gap + 0.0002 * v, 0.006 * std::sin(angle);
        }
        return x;
    }
};

}  // namespace

TEST_CASE("The contact barrier is smooth, vanishes at its reach and is infinite at zero")
{
    const double reach = 4e-6;
    for (const double y : {1e-4, 0.01, 0.3, 0.9, 0.9999}) {
        const double step = 1e-6 * y * reach;
        const ContactBarrier here = contact_barrier(y * reach, reach), high = contact_barrier(y * reach + step, reach),
                             low = contact_barrier(y * reach - step, reach);
        REQUIRE(here.energy > 0);
        REQUIRE(here.first < 0);
        REQUIRE(here.second > 0);
        REQUIRE(here.first == Approx((high.energy - low.energy) / (2 * step)).epsilon(1e-3));
        REQUIRE(here.second == Approx((high.first - low.first) / (2 * step)).epsilon(1e-3));
    }
    REQUIRE(contact_barrier(0.25 * reach, reach).energy == Approx(0.75 * 0.75 * std::log(4)));
    REQUIRE(contact_barrier(reach, reach).energy == 0);
    REQUIRE(std::isinf(contact_barrier(0, reach).energy));
}

TEST_CASE("The factor of parallel edges has its derivatives and vanishes with them")
{
    Random random(4, "parallel");
    for (int i = 0; i < 20; ++i) {
        Eigen::Matrix<double, 4, 3> x;
        for (int a = 0; a < 4; ++a)
            for (int c = 0; c < 3; ++c) x(a, c) = random.normal();
        x.row(3) = x.row(2) + (x.row(1) - x.row(0)) + 0.1 * x.row(3);
        const double share_of = 2 + i % 3;
        const Eigen::RowVector3d u = x.row(1) - x.row(0), v = x.row(3) - x.row(2);
        const double limit = share_of * u.cross(v).squaredNorm();
        const ParallelFade fade = parallel_fade(x, limit);
        REQUIRE(fade.value == Approx((2 - 1 / share_of) / share_of));
        const double step = 1e-6;
        for (int k = 0; k < 12; ++k) {
            Eigen::Matrix<double, 4, 3> plus = x, minus = x;
            plus(k / 3, k % 3) += step;
            minus(k / 3, k % 3) -= step;
            const ParallelFade high = parallel_fade(plus, limit), low = parallel_fade(minus, limit);
            REQUIRE(fade.gradient[k] == Approx((high.value - low.value) / (2 * step)).margin(1e-5));
            REQUIRE((fade.hessian.col(k) - (high.gradient - low.gradient) / (2 * step)).norm() <
                    1e-5 * (1 + fade.hessian.norm()));
        }
        REQUIRE(parallel_fade(x, 0.5 * u.cross(v).squaredNorm()).value == 1);
        x.row(3) = x.row(2) + 2 * (x.row(1) - x.row(0));
        REQUIRE(std::abs(parallel_fade(x, limit).value) < 1e-12);
    }
}

TEST_CASE("Skin near skin is repelled with the derivatives of its energy")
{
    Sheets sheets(5e6);
    const Points x = Sheets::apart(6e-4);
    sheets.term->set_pairs(SurfaceParts(sheets.triangles, 6).close_pairs(x, 3e-3));
    REQUIRE(sheets.term->stencils().size() > 6);
    const Objective objective(sheets.body);
    REQUIRE(objective.energy(x) > 0);
    Eigen::VectorXd gradient, absolute;
    objective.gradient(x, gradient, absolute);
    // The lower sheet is pushed down, the upper one as much up.
    double lower = 0, upper = 0;
    for (int v = 0; v < 6; ++v) (v < 3 ? lower : upper) -= gradient[3 * v + 1];
    REQUIRE(lower < 0);
    REQUIRE(upper == Approx(-lower).epsilon(1e-9));

    const Eigen::MatrixXd exact = hessian_of(objective, x, HessianKind::exact);
    Eigen::MatrixXd numeric(18, 18);
    const double step = 1e-9;
    for (int k = 0; k < 18; ++k) {
        Points plus = x, minus = x;
        plus(k / 3, k % 3) += step;
        minus(k / 3, k % 3) -= step;
        const double difference = (objective.energy(plus) - objective.energy(minus)) / (2 * step);
        REQUIRE(gradient[k] == Approx(difference).epsilon(1e-4).margin(1e-5 * gradient.norm()));
        Eigen::VectorXd high, low;
        objective.gradient(plus, high, absolute);
        objective.gradient(minus, low, absolute);
        numeric.col(k) = (high - low) / (2 * step);
    }
    REQUIRE((exact - numeric).norm() < 1e-4 * exact.norm());
    for (const HessianKind kind : {HessianKind::projected, HessianKind::gauss_newton}) {
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(hessian_of(objective, x, kind));
        REQUIRE(solver.eigenvalues()(0) > -1e-9 * exact.norm());
    }
    // Beyond the contact distance there is nothing, and so where skin is as near at rest.
    REQUIRE(objective.energy(Sheets::apart(5e-3)) == 0);
    sheets.body.set_rest(x);
    sheets.term->set_pairs(SurfaceParts(sheets.triangles, 6).close_pairs(x, 3e-3));
    REQUIRE(Objective(sheets.body).energy(x) == 0);
}
