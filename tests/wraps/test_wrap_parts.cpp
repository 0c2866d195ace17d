// SPDX-License-Identifier: Apache-2.0
// The barriers of one prism, and the minimiser.
#include "ndg/core/error.h"
#include "ndg/geometry/prism.h"
#include "ndg/wraps/minimise.h"
#include "ndg/wraps/prism_barrier.h"
#include "wraps/gradient_error.h"

#include <Eigen/Eigenvalues>

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

using namespace ndg;
using Catch::Matchers::Contains;
using test::gradient_error;

namespace {

PrismVertices skewed_prism()
{
    PrismVertices prism;
    prism << 0.010, 0.001, 0.011, 0.001, 0.012, 0.010, 0.0, 0.0, 0.0102,  //
        0.0085, 0.002, 0.0095, 0.0005, 0.0095, 0.0088, 0.002, 0.0015, 0.0091;
    return prism;
}

BarrierBounds active_bounds()
{
    return {0.02, 0.9, 0.0004, 0.004, 1e-5, 3e-4};
}

}  // namespace

TEST_CASE("wraps: a prism's quality is the element's own scaled Jacobian and its height")
{
    const PrismVertices prism = skewed_prism();
    CHECK(prism_quality(prism)[0] == Approx(prism_min_scaled_jacobian(prism)).epsilon(1e-12));
    PrismVertices right;
    right << 0, 0, 0.003, 0.01, 0, 0.003, 0, 0.02, 0.003, 0, 0, 0, 0.01, 0, 0, 0, 0.02, 0;
    CHECK(prism_quality(right)[1] == Approx(0.003));
    CHECK(prism_quality(right)[2] == Approx(0.01 * 0.02));
    CHECK(prism_quality(right)[0] == Approx(prism_min_scaled_jacobian(right)).epsilon(1e-12));
}

TEST_CASE("wraps: the barrier's gradient, its definite Hessian, and where it is infinite")
{
    const PrismVertices prism = skewed_prism();
    PrismVertices gradient = PrismVertices::Zero();
    Eigen::Matrix<double, 18, 18> hessian = Eigen::Matrix<double, 18, 18>::Zero();
    const double value = prism_barrier(prism, active_bounds(), &gradient, &hessian);
    REQUIRE(value > 0.0);
    const auto energy = [](const Eigen::MatrixXd& at) {
        return prism_barrier(PrismVertices(at), active_bounds(), nullptr, nullptr);
    };
    CHECK(gradient_error(energy, prism, gradient, 1e-8) < 1e-5);
    CHECK((hessian - hessian.transpose()).norm() < 1e-9 * hessian.norm());
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 18, 18>> spectrum(hessian);
    CHECK(spectrum.eigenvalues()[0] > -1e-9 * spectrum.eigenvalues()[17]);
    CHECK(spectrum.eigenvalues()[17] > 0.0);

    PrismVertices flipped;
    flipped << prism.bottomRows<3>(), prism.topRows<3>();
    CHECK(std::isinf(prism_barrier(flipped, active_bounds(), nullptr, nullptr)));
    BarrierBounds loose = active_bounds();
    loose.active_jacobian = loose.jacobian + 1e-6;
    loose.active_thickness = loose.thickness + 1e-9;
    loose.active_area = loose.area + 1e-12;
    CHECK(prism_barrier(prism, loose, nullptr, nullptr) == 0.0);
}

TEST_CASE("wraps: the minimiser finds a known minimum and never enters what is forbidden")
{
    Points points(2, 3), target(2, 3);
    points << 1, 1, 1, -1, 2, 0.5;
    target << 0.2, -0.1, 0.3, 0.4, 0.5, -0.6;
    const auto same = [](const Points& force) { return force; };
    const auto free = [](const Points&, Points&) {};
    const auto bowl = [&](const Points& x, Points& gradient) {
        gradient = 2.0 * (x - target);
        gradient.row(1) *= 25.0;
        return (x - target).row(0).squaredNorm() + 25.0 * (x - target).row(1).squaredNorm();
    };
    MinimiseOptions options;
    options.max_move = 0.5;
    options.tolerance = 0.0;
    const MinimiseResult result = minimise(bowl, same, free, options, points);
    CHECK((points - target).norm() < 1e-6);
    CHECK(result.iterations < 60);

    // The same behind a wall at x > 0.5 that is only seen by its infinite values.
    points << 1, 1, 1, 1, 2, 0.5;
    const auto walled = [&](const Points& x, Points& gradient) {
        REQUIRE(x.allFinite());
        if (x.col(0).minCoeff() <= 0.5) return std::numeric_limits<double>::infinity();
        return bowl(x, gradient);
    };
    minimise(walled, same, free, options, points);
    CHECK(points.col(0).minCoeff() > 0.5);
    CHECK(points(0, 1) < 1.0);
    points(0, 0) = 0.0;
    CHECK_THROWS_WITH(minimise(walled, same, free, options, points), Contains("invalid state"));
}
