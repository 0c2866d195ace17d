// SPDX-License-Identifier: Apache-2.0
// Every energy against finite differences, numeric eigenvalues and closed forms.
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/elastic/neo_hookean.h"
#include "ndg/elastic/projection.h"
#include "ndg/elastic/shell.h"
#include "ndg/geometry/triangle_mesh.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <functional>

using namespace ndg;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

Matrix3d random_matrix(std::uint64_t index, double spread)
{
    Random random(7, "fem-test", index);
    Matrix3d m = Matrix3d::Identity();
    for (int i = 0; i < 9; ++i) m(i) += spread * random.normal();
    return m;
}

Matrix3d random_rotation(std::uint64_t index)
{
    Random random(11, "fem-rotation", index);
    return Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal())
        .normalized()
        .toRotationMatrix();
}

Hinge random_hinge(std::uint64_t index)
{
    Random random(3, "fem-hinge", index);
    const auto jitter = [&]() -> Vector3d {
        return Vector3d(random.normal(), random.normal(), random.normal()) * 0.004;
    };
    return {Vector3d(0, 0, 0) + jitter(), Vector3d(0, 0.02, 0) + jitter(), Vector3d(-0.015, 0.01, -0.003) + jitter(),
            Vector3d(0.018, 0.008, -0.006) + jitter()};
}

template <int Size>
using Vector = Eigen::Matrix<double, Size, 1>;

/// Central differences of a scalar function.
template <int Size>
Vector<Size> numeric_gradient(const std::function<double(const Vector<Size>&)>& f, const Vector<Size>& x, double step)
{
    Vector<Size> gradient;
    for (int i = 0; i < Size; ++i) {
        Vector<Size> plus = x, minus = x;
        plus(i) += step;
        minus(i) -= step;
        gradient(i) = (f(plus) - f(minus)) / (2 * step);
    }
    return gradient;
}

template <int Size>
Eigen::Matrix<double, Size, Size> numeric_jacobian(const std::function<Vector<Size>(const Vector<Size>&)>& f,
                                                   const Vector<Size>& x, double step)
{
    Eigen::Matrix<double, Size, Size> jacobian;
    for (int i = 0; i < Size; ++i) {
        Vector<Size> plus = x, minus = x;
        plus(i) += step;
        minus(i) -= step;
        jacobian.col(i) = (f(plus) - f(minus)) / (2 * step);
    }
    return jacobian;
}

template <typename A, typename B>
void require_close(const A& value, const B& expected, double relative)
{
    const double scale = expected.norm();
    REQUIRE(scale > 0);  // a comparison of zeros would say nothing
    REQUIRE((value - expected).norm() <= relative * scale);
}

Vector12 pack(const Hinge& h)
{
    Vector12 x;
    x << h.x0, h.x1, h.left, h.right;
    return x;
}

Hinge unpack(const Vector12& x)
{
    return {x.segment<3>(0), x.segment<3>(3), x.segment<3>(6), x.segment<3>(9)};
}

const Lame muscle = lame_parameters(45e3, 0.47);

}  // namespace

TEST_CASE("Lame parameters")
{
    REQUIRE(muscle.mu == Approx(45e3 / 2.94));
    REQUIRE(muscle.lambda / muscle.mu == Approx(0.94 / 0.06));
    MaterialOptions material;
    check_options(material);
    for (const double outside : {0.125, 0.5}) {
        material.poisson_ratio = outside;
        REQUIRE_THROWS_AS(check_options(material), InputError);
    }
}

TEST_CASE("Neo-Hookean stress and Hessian are the derivatives of the energy")
{
    for (std::uint64_t i = 0; i < 20; ++i) {
        const Matrix3d f = random_matrix(i, i < 10 ? 0.1 : 0.7);  // among the second ten are inverted ones
        const Vector<9> x = Eigen::Map<const Vector<9>>(f.data());
        const auto energy = [&](const Vector<9>& y) {
            return neo_hookean_energy(Eigen::Map<const Matrix3d>(y.data()), muscle);
        };
        const auto stress = [&](const Vector<9>& y) -> Vector<9> {
            const Matrix3d p = neo_hookean_stress(Eigen::Map<const Matrix3d>(y.data()), muscle);
            return Eigen::Map<const Vector<9>>(p.data());
        };
        require_close(stress(x), numeric_gradient<9>(energy, x, 1e-5), 1e-7);
        require_close(neo_hookean_hessian(f, muscle), numeric_jacobian<9>(stress, x, 1e-5), 1e-7);
    }
}

TEST_CASE("The analytic eigensystem clamps as a numeric one does")
{
    int indefinite = 0, inverted = 0;
    for (std::uint64_t i = 0; i < 50; ++i) {
        const Matrix3d f = random_matrix(i, i < 25 ? 0.15 : 0.8);
        const Matrix9 hessian = neo_hookean_hessian(f, muscle);
        const Eigen::SelfAdjointEigenSolver<Matrix9> solver(hessian);
        indefinite += solver.eigenvalues()(0) < -1e-6 * muscle.mu;
        inverted += f.determinant() < 0;
        require_close(neo_hookean_projected_hessian(f, muscle), clamp_eigenvalues<9>(hessian), 1e-9);
    }
    REQUIRE(indefinite > 10);
    REQUIRE(inverted > 5);
}

TEST_CASE("A rotated rest state has no energy and no stress; energy is objective")
{
    for (std::uint64_t i = 0; i < 5; ++i) {
        const Matrix3d r = random_rotation(i);
        REQUIRE(std::abs(neo_hookean_energy(r, muscle)) < 1e-9 * muscle.mu);
        REQUIRE(neo_hookean_stress(r, muscle).norm() < 1e-9 * muscle.mu);
        const Matrix3d f = random_matrix(i, 0.3);
        REQUIRE(neo_hookean_energy(f, muscle) > 1e-3 * muscle.mu);
        REQUIRE(neo_hookean_energy(r * f, muscle) == Approx(neo_hookean_energy(f, muscle)).epsilon(1e-12));
        REQUIRE(neo_hookean_energy(f * r, muscle) == Approx(neo_hookean_energy(f, muscle)).epsilon(1e-12));
    }
}

TEST_CASE("Closed-form responses of the material")
{
    const double mu = muscle.mu, lambda = muscle.lambda, alpha = 1 + mu / lambda;
    SECTION("volumetric: F = s I gives P = (mu s + lambda (s^3 - alpha) s^2) I")
    {
        for (const double s : {0.8, 0.97, 1.1}) {
            const Matrix3d p = neo_hookean_stress(s * Matrix3d::Identity(), muscle);
            const double expected = mu * s + lambda * (s * s * s - alpha) * s * s;
            REQUIRE((p - expected * Matrix3d::Identity()).norm() < 1e-9 * lambda);
            REQUIRE(std::abs(expected) > 1e-2 * mu);
        }
    }
    SECTION("simple shear by g: energy mu/2 g^2, since the volume stays")
    {
        for (const double g : {0.05, 0.4, 1.5}) {
            Matrix3d f = Matrix3d::Identity();
            f(0, 1) = g;
            REQUIRE(neo_hookean_energy(f, muscle) == Approx(0.5 * mu * g * g));
            REQUIRE(neo_hookean_stress(f, muscle)(0, 1) == Approx(mu * g));
        }
    }
    SECTION("uniaxial: P = mu s + lambda (s - alpha) along, mu + lambda (s - alpha) s across")
    {
        for (const double s : {0.7, 0.95, 1.4}) {
            const Matrix3d p = neo_hookean_stress(Vector3d(s, 1, 1).asDiagonal(), muscle);
            REQUIRE(p(0, 0) == Approx(mu * s + lambda * (s - alpha)));
            REQUIRE(p(1, 1) == Approx(mu + lambda * (s - alpha) * s));
            REQUIRE(p(2, 2) == Approx(p(1, 1)));
        }
    }
    SECTION("small strains: Lame parameters mu and lambda - mu")
    {
        Matrix3d strain;
        strain << 2, 0.5, -0.3, 0.5, -1, 0.2, -0.3, 0.2, 0.7;
        strain *= 1e-5;
        const Matrix3d expected = 2 * mu * strain + (lambda - mu) * strain.trace() * Matrix3d::Identity();
        require_close(neo_hookean_stress(Matrix3d::Identity() + strain, muscle), expected, 1e-3);
    }
}

TEST_CASE("Stretching of a skin edge")
{
    const double rest = 0.02;
    for (const double factor : {0.7, 1.3}) {
        Vector6 x;
        x << 0.001, -0.002, 0.003, 0.001 + 0.6 * rest * factor, -0.002 + 0.8 * rest * factor, 0.003;
        const auto energy = [&](const Vector6& y) { return stretch_energy(y.head<3>(), y.tail<3>(), rest); };
        const std::function<Vector6(const Vector6&)> gradient = [&](const Vector6& y) {
            return stretch_gradient(y.head<3>(), y.tail<3>(), rest);
        };
        REQUIRE(energy(x) == Approx(0.5 * (factor - 1) * (factor - 1)));
        require_close(gradient(x), numeric_gradient<6>(energy, x, 1e-7), 1e-6);
        const Matrix6 hessian = stretch_hessian(x.head<3>(), x.tail<3>(), rest);
        require_close(hessian, numeric_jacobian<6>(gradient, x, 1e-7), 1e-6);
        const Matrix6 projected = stretch_projected_hessian(x.head<3>(), x.tail<3>(), rest);
        require_close(projected, clamp_eigenvalues<6>(hessian), 1e-10);
        REQUIRE(((projected - hessian).norm() > 0.1 * hessian.norm()) == (factor < 1));
    }
}

TEST_CASE("Dihedral angle: gradient and Hessian")
{
    for (std::uint64_t i = 0; i < 20; ++i) {
        const Vector12 x = pack(random_hinge(i));
        const auto angle = [](const Vector12& y) {
            const Hinge h = unpack(y);
            return dihedral_angle(h.x0, h.x1, h.left, h.right);
        };
        const std::function<Vector12(const Vector12&)> gradient = [](const Vector12& y) {
            return dihedral_gradient(unpack(y));
        };
        REQUIRE(std::abs(angle(x)) > 1e-3);
        require_close(gradient(x), numeric_gradient<12>(angle, x, 1e-7), 1e-6);
        require_close(dihedral_hessian(unpack(x)), numeric_jacobian<12>(gradient, x, 1e-7), 1e-6);
    }
}

TEST_CASE("Bending energy: derivatives, clamp and the jump of the angle")
{
    int faded = 0;
    for (std::uint64_t i = 0; i < 20; ++i) {
        Hinge hinge = random_hinge(i);
        HingeRest rest{0.2 * static_cast<double>(i) - 1.5, 2.5, 1.5e-4, 1.6e-4};
        if (i >= 10) {
            // Wings pulled towards the edge: less than a tenth of the rest area left.
            const Eigen::Vector3d middle = 0.4 * hinge.x0 + 0.6 * hinge.x1;
            hinge.left = middle + 0.07 * (hinge.left - middle);
            if (i >= 15) hinge.right = middle + 0.06 * (hinge.right - middle);
        }
        const Vector12 x = pack(hinge);
        const double step = i < 10 ? 1e-7 : 1e-8;
        const auto energy = [&](const Vector12& y) { return bend_energy(unpack(y), rest); };
        const std::function<Vector12(const Vector12&)> gradient = [&](const Vector12& y) {
            return bend_gradient(unpack(y), rest);
        };
        const double difference = dihedral_angle(hinge.x0, hinge.x1, hinge.left, hinge.right) - rest.angle;
        const double full = 0.5 * rest.weight * difference * difference;
        faded += energy(x) < 0.99 * full;
        if (i < 10) REQUIRE(energy(x) == Approx(full));
        require_close(gradient(x), numeric_gradient<12>(energy, x, step), 1e-5);
        const Matrix12 hessian = bend_hessian(unpack(x), rest);
        require_close(hessian, numeric_jacobian<12>(gradient, x, step), 1e-5);
        const Matrix12 projected = bend_projected_hessian(unpack(x), rest);
        const Eigen::SelfAdjointEigenSolver<Matrix12> exact(hessian), clamped(projected);
        REQUIRE(exact.eigenvalues()(0) < 0);
        const Vector12 expected = exact.eigenvalues().cwiseMax(0.0);
        REQUIRE((clamped.eigenvalues() - expected).norm() < 1e-9 * expected.norm());
    }
    REQUIRE(faded >= 8);
    Hinge hinge = random_hinge(0);
    const double angle = dihedral_angle(hinge.x0, hinge.x1, hinge.left, hinge.right);
    const double turn = 2 * 3.14159265358979323846;
    const HingeRest rest{angle + turn - 0.1, 1, 1.5e-4, 1.6e-4};
    REQUIRE(bend_energy(hinge, rest) == Approx(0.5 * 0.1 * 0.1));
    hinge.left = hinge.x0;  // collapsed
    REQUIRE(bend_energy(hinge, rest) == 0);
    REQUIRE(bend_gradient(hinge, rest).norm() == 0);
    REQUIRE(bend_hessian(hinge, rest).norm() == 0);
}
