// SPDX-License-Identifier: Apache-2.0
// The orthotropic, saturating material of Romero et al. 2020 on tetrahedra.
#include "derivatives.h"

#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/elastic/flesh_term.h"
#include "ndg/elastic/fung_lanes.h"
#include "ndg/elastic/projection.h"

#include <catch2/catch.hpp>

#include <Eigen/Dense>

#include <cmath>
#include <limits>

using namespace ndg;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

using Matrix9 = Eigen::Matrix<double, 9, 9>;

/// The unit cube in six tetrahedra about the diagonal from vertex 0 to vertex 7; vertex 4 z + 2 y + x.
struct Cube {
    Points rest{8, 3};
    Tetrahedra cells{6, 4};

    Cube()
    {
        for (int v = 0; v < 8; ++v) rest.row(v) << v % 2, v / 2 % 2, v / 4;
        cells << 0, 1, 3, 7, 0, 3, 2, 7, 0, 2, 6, 7, 0, 6, 4, 7, 0, 4, 5, 7, 0, 5, 1, 7;
    }
    ElasticBody elastic(const std::vector<OrthotropicMaterial>& materials, int num_fixed = 0) const
    {
        ElasticBody body(8, num_fixed);
        body.add(std::make_unique<FleshTerm<FungLanes, TetrahedronElement>>(cells, materials, 1.0, 8));
        body.set_rest(rest);
        return body;
    }
};

/// Materials with other moduli and normals, and one with weights that no pair of moduli has.
std::vector<OrthotropicMaterial> materials(double scale = 1)
{
    std::vector<OrthotropicMaterial> result;
    for (const auto& [normal, tangent] : {std::pair(1.0, 3.0), {3.0, 1.0}, {2.0, 2.0}, {1.0, 40.0}, {5.0, 1.5}}) {
        const Vector3d axis(normal - 2, tangent, 0.4 * normal);
        result.push_back(orthotropic_material({scale * normal, scale * tangent, 0.2, 4}, axis));
    }
    OrthotropicMaterial general = result[0];
    general.weights << 0.3, 0.9, 0.2, 0.9, 1.0, 0.1, 0.2, 0.1, 0.6;
    result.push_back(general);
    return result;
}

/// Stress along the stretch s of one axis with modulus weight `along`, the others with `across` and free: solved by
/// hand for their stretch t, by bisection of the stress across.
struct Uniaxial {
    double stretch_across = 0, stress = 0;

    Uniaxial(double s, double along, double across, const OrthotropicMaterial& m)
    {
        const double e = 0.5 * (s * s - 1);
        const auto growth = [&](double t) {
            const double f = 0.5 * (t * t - 1);
            return m.mu * std::exp(m.saturation * (along * e * e + 2 * across * f * f));
        };
        const auto stress_across = [&](double t) {
            return growth(t) * across * (t * t - 1) * t + m.lambda * (s * t * t - 1) * s * t;
        };
        double low = 0.3, high = 2;
        for (int i = 0; i < 200; ++i) {
            const double middle = 0.5 * (low + high);
            (stress_across(middle) > 0 ? high : low) = middle;
        }
        const double t = stretch_across = 0.5 * (low + high);
        stress = growth(t) * along * (s * s - 1) * s + m.lambda * (s * t * t - 1) * t * t;
    }
};

}  // namespace

TEST_CASE("Orthotropic flesh: energy of an affine deformation, derivatives, semi-definite projection")
{
    const Cube cube;
    const std::vector<OrthotropicMaterial> all = materials();
    const ElasticBody elastic = cube.elastic(all, 4);
    const Objective objective(elastic);
    Matrix3d f;
    f << 1.1, 0.2, -0.1, 0.05, 0.9, 0.15, -0.05, 0.1, 1.2;
    Points x = cube.rest * f.transpose();
    double expected = 0;
    for (const OrthotropicMaterial& material : all) expected += orthotropic_energy(f, material) / 6;
    REQUIRE(expected > 0.1);
    REQUIRE(objective.energy(x) == Approx(expected).epsilon(1e-12));
    REQUIRE(std::abs(objective.energy(cube.rest)) < 1e-12 * expected);
    const Matrix3d turn = Eigen::AngleAxisd(2.0, Vector3d(1, 2, -1).normalized()).toRotationMatrix();
    REQUIRE(objective.energy(x * turn.transpose()) == Approx(expected).epsilon(1e-12));

    Random random(3, "orthotropic");
    for (const double spread : {0.1, 0.3}) {
        for (int v = 4; v < 8; ++v) {
            for (int c = 0; c < 3; ++c) x(v, c) += spread * random.normal();
        }
        test::require_derivatives(objective, x);
    }
    const Eigen::MatrixXd exact = test::hessian_of(objective, x, HessianKind::exact);
    const Eigen::MatrixXd projected = test::hessian_of(objective, x, HessianKind::projected);
    REQUIRE(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(exact).eigenvalues()(0) < 0);
    REQUIRE(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(projected).eigenvalues()(0) > -1e-9 * projected.norm());
}

TEST_CASE("Projected Hessians of orthotropic flesh are those of the general eigen solver, and stability a lower bound")
{
    Random random(8, "orthotropic clamp");
    Eigen::Matrix<double, 4, 3> shape;
    shape << 0.02, 0, 0.001, 0.003, 0.018, 0, -0.002, 0.001, 0.025, 0, 0, 0;
    const Eigen::Matrix<double, 3, 4> gradient = TetrahedronElement::gradient_operator(shape);
    Eigen::Matrix<double, 9, 12> to_f = Eigen::Matrix<double, 9, 12>::Zero();
    for (int a = 0; a < 4; ++a) {
        for (int j = 0; j < 3; ++j) to_f.block<3, 3>(3 * j, 3 * a).diagonal().array() = gradient(j, a);
    }
    const Eigen::MatrixXd inverse = to_f.completeOrthogonalDecomposition().pseudoInverse();
    const std::vector<OrthotropicMaterial> all = materials(1e4);
    int indefinite = 0, untouched = 0;
    for (int round = 0; round < 200; ++round) {
        Matrix3d f = Matrix3d::Identity();
        const double spread = round < 20 ? 0 : round < 100 ? 0.1 : 0.35;
        for (int k = 0; k < 9; ++k) f(k) += spread * random.normal();
        const OrthotropicMaterial& material = all[static_cast<std::size_t>(round) % all.size()];
        Points x = shape * f.transpose();
        Tetrahedra cell(1, 4);
        cell << 1, 0, 2, 3;
        ElasticBody body(4, 0);
        if (TetrahedronElement::volume(corner_positions<4>(Points(shape), cell.data())) < 0) cell << 0, 1, 2, 3;
        body.add(std::make_unique<FleshTerm<FungLanes, TetrahedronElement>>(
            cell, std::vector<OrthotropicMaterial>{material}, 1.0, 4));
        body.set_rest(shape);
        const Objective objective(body);
        const Eigen::MatrixXd exact = test::hessian_of(objective, x, HessianKind::exact);
        const Eigen::MatrixXd projected = test::hessian_of(objective, x, HessianKind::projected);
        const Matrix9 by_f = inverse.transpose() * exact * inverse;
        const Matrix9 clamped = clamp_eigenvalues<9>(by_f);
        const Eigen::MatrixXd expected = to_f.transpose() * clamped * to_f;
        CAPTURE(round);
        REQUIRE((projected - expected).norm() < 1e-8 * expected.norm());
        const Eigen::SelfAdjointEigenSolver<Matrix9> solver(by_f);
        indefinite += solver.eigenvalues()(0) < -1e-3 * by_f.norm();
        untouched += (projected - exact).norm() == 0;

        std::array<Lanes3, 3> columns;
        for (std::size_t j = 0; j < 3; ++j) {
            for (std::size_t i = 0; i < 3; ++i) columns[j][i] = f(static_cast<int>(i), static_cast<int>(j));
        }
        const FungLanes lanes(columns, {&material, &material, &material, &material}, 1.0);
        const double volume = std::abs(TetrahedronElement::volume(shape));
        const double sigma = material.weights
                                 .cwiseProduct((0.5 * material.basis.transpose() *
                                                (f.transpose() * f - Matrix3d::Identity()) * material.basis)
                                                   .cwiseAbs2())
                                 .sum();
        const double stiffness = volume * material.mu * std::exp(material.saturation * sigma);
        REQUIRE(solver.eigenvalues()(0) >= lanes.stability()[2] * stiffness - 1e-6 * by_f.norm());
    }
    REQUIRE(indefinite > 50);
    REQUIRE(untouched >= 20);
}

TEST_CASE("Equation 5: parameters from the moduli along the normal and along the skin")
{
    const OrthotropicMaterial m = orthotropic_material({10e3, 40e3, 0.2, 4}, Vector3d(0, 3, 0));
    REQUIRE(m.mu == Approx(40e3 / 2.4));
    REQUIRE(m.lambda == Approx(40e3 * 0.2 / (1.2 * 0.6)));
    REQUIRE(m.weights(0, 0) == Approx(0.25));
    REQUIRE(m.weights(1, 1) == 1);
    REQUIRE(m.weights(2, 2) == 1);
    REQUIRE(m.weights(0, 1) == 1);
    REQUIRE(m.weights(2, 1) == 1);
    REQUIRE((m.basis.col(0) - Vector3d::UnitY()).norm() < 1e-15);
    REQUIRE((m.basis.transpose() * m.basis - Matrix3d::Identity()).norm() < 1e-14);
    REQUIRE(m.basis.determinant() == Approx(1));
    const OrthotropicMaterial soft = orthotropic_material({10e3, 4e3, 0.2, 4}, Vector3d(1, 1, 0));
    REQUIRE(soft.weights(0, 1) == 1);
    REQUIRE(soft.weights(1, 2) == Approx(0.4));
    // With equal moduli small strains are those of the isotropic material.
    const OrthotropicMaterial isotropic = orthotropic_material({20e3, 20e3, 0.2, 4}, Vector3d(1, 2, 3));
    const Uniaxial small(1 + 1e-6, 1, 1, isotropic);
    REQUIRE(small.stress / 1e-6 == Approx(20e3).epsilon(1e-5));
    REQUIRE((small.stretch_across - 1) / 1e-6 == Approx(-0.2).epsilon(1e-5));
    // With unequal ones the slope along the normal is not Y_N (docs/paper-map.md).
    const Uniaxial along(1 + 1e-6, 0.25, 1, m);
    REQUIRE(along.stress / 1e-6 == Approx(2 * m.mu * 0.25 + m.lambda * m.mu / (m.mu + m.lambda)).epsilon(1e-5));

    const auto refused = [](const OrthotropicModuli& moduli, const Vector3d& normal) {
        REQUIRE_THROWS_AS(orthotropic_material(moduli, normal), Error);
    };
    refused({0, 1e4, 0.2, 4}, Vector3d::UnitX());
    refused({1e4, -1, 0.2, 4}, Vector3d::UnitX());
    refused({1e4, std::nan(""), 0.2, 4}, Vector3d::UnitX());
    refused({1e4, 1e4, 0.5, 4}, Vector3d::UnitX());
    refused({1e4, 1e4, 0.2, 0}, Vector3d::UnitX());
    refused({1e4, 1e4, 0.2, 4}, Vector3d::Zero());
}

TEST_CASE("A cube that is pulled along or across the normal, its sides free, follows the closed form")
{
    const Cube cube;
    for (const Vector3d& normal : {Vector3d(Vector3d::UnitX()), Vector3d(Vector3d::UnitZ())}) {
        const OrthotropicMaterial m = orthotropic_material({8e3, 20e3, 0.2, 4}, normal);
        const double along_normal = m.weights(0, 0);
        const ElasticBody elastic = cube.elastic(std::vector<OrthotropicMaterial>(6, m));
        const Objective objective(elastic);
        double last = -std::numeric_limits<double>::infinity();
        for (const double s : {0.8, 0.9, 1.02, 1.2, 1.5, 1.8}) {
            CAPTURE(s, normal.transpose());
            Matrix3d f = Matrix3d::Identity();
            double stress = 0;
            if (normal[0] == 1) {  // pulled along the normal, x
                const Uniaxial state(s, along_normal, 1, m);
                f.diagonal() << s, state.stretch_across, state.stretch_across;
                stress = state.stress;
            } else {  // along the skin: y and z, the normal, contract by different amounts; alternate between the two
                double y = 1, z = 1;
                const auto solve = [&](double& t, double other, double weight, double other_weight) {
                    double low = 0.3, high = 2;
                    for (int i = 0; i < 100; ++i) {
                        t = 0.5 * (low + high);
                        const double e = 0.5 * (s * s - 1), g = 0.5 * (t * t - 1), h = 0.5 * (other * other - 1);
                        const double growth =
                            m.mu * std::exp(m.saturation * (e * e + weight * g * g + other_weight * h * h));
                        const double pressed =
                            growth * weight * (t * t - 1) * t + m.lambda * (s * t * other - 1) * s * other;
                        (pressed > 0 ? high : low) = t;
                    }
                };
                for (int i = 0; i < 300; ++i) {
                    solve(y, z, 1, along_normal);
                    solve(z, y, along_normal, 1);
                }
                f.diagonal() << s, y, z;
                const double e = 0.5 * (s * s - 1), g = 0.5 * (y * y - 1), h = 0.5 * (z * z - 1);
                stress = m.mu * std::exp(m.saturation * (e * e + g * g + along_normal * h * h)) * (s * s - 1) * s +
                         m.lambda * (s * y * z - 1) * y * z;
            }
            const Points x = cube.rest * f.transpose();
            Eigen::VectorXd gradient, absolute;
            objective.gradient(x, gradient, absolute);
            double pull = 0;
            for (int v = 0; v < 8; ++v) {
                if (v % 2 == 1) pull += gradient[3 * v];
                REQUIRE(std::abs(gradient[3 * v + 1]) < 1e-8 * m.mu);
                REQUIRE(std::abs(gradient[3 * v + 2]) < 1e-8 * m.mu);
            }
            REQUIRE(pull == Approx(stress).epsilon(1e-8));  // N on 1 m^2
            REQUIRE(stress > last);
            last = stress;
        }
        REQUIRE(last > 3 * m.mu);
    }
}

TEST_CASE("A patch of orthotropic flesh in uniform strain: inner vertices are in balance")
{
    // Eight cubes of six tetrahedra about one inner vertex that lies off the middle.
    Points rest(27, 3);
    for (int v = 0; v < 27; ++v) rest.row(v) << 0.5 * (v % 3), 0.5 * (v / 3 % 3), 0.5 * (v / 9);
    rest.row(13) += Eigen::RowVector3d(0.07, -0.05, 0.09);
    Tetrahedra cells(48, 4);
    const Cube cube;
    for (int c = 0; c < 8; ++c) {
        for (int t = 0; t < 6; ++t) {
            for (int a = 0; a < 4; ++a) {
                const int corner = cube.cells(t, a);
                cells(6 * c + t, a) =
                    (c % 2 + corner % 2) + 3 * (c / 2 % 2 + corner / 2 % 2) + 9 * (c / 4 + corner / 4);
            }
        }
    }
    const OrthotropicMaterial material = orthotropic_material({8e3, 20e3, 0.2, 4}, Vector3d(1, 1, 2));
    ElasticBody body(27, 0);
    body.add(std::make_unique<FleshTerm<FungLanes, TetrahedronElement>>(
        cells, std::vector<OrthotropicMaterial>(48, material), 1.0, 27));
    body.set_rest(rest);
    const Objective objective(body);
    Matrix3d f;
    f << 1.2, 0.1, 0, -0.2, 0.9, 0.1, 0.1, 0, 1.1;
    Points x = rest * f.transpose();
    Eigen::VectorXd gradient, absolute;
    objective.gradient(x, gradient, absolute);
    REQUIRE(absolute.segment<3>(39).norm() > 1e3);
    REQUIRE(gradient.segment<3>(39).norm() < 1e-12 * absolute.segment<3>(39).norm());
    REQUIRE(gradient.norm() > 100);
    x.row(13) += Eigen::RowVector3d(0.01, 0, 0);
    objective.gradient(x, gradient, absolute);
    REQUIRE(gradient.segment<3>(39).norm() > 10);
}

TEST_CASE("Where the exponential would overflow the energy is infinite and nothing is not-a-number")
{
    const Cube cube;
    const ElasticBody elastic = cube.elastic(materials());
    const Objective objective(elastic);
    const double infinity = std::numeric_limits<double>::infinity();
    for (const double stretch : {6.0, 1e3, 1e80, 1e200}) {
        const Points x = stretch * cube.rest;
        REQUIRE(objective.energy(x) == infinity);
    }
    Points x = 6 * cube.rest;
    Eigen::VectorXd gradient, absolute;
    objective.gradient(x, gradient, absolute);
    REQUIRE(gradient.allFinite());
    REQUIRE(test::hessian_of(objective, x, HessianKind::exact).allFinite());
    REQUIRE(test::hessian_of(objective, x, HessianKind::projected).allFinite());
    x(3, 1) = std::nan("");
    REQUIRE(objective.energy(x) == infinity);
    REQUIRE(orthotropic_energy(Matrix3d::Constant(std::nan("")), materials()[0]) == infinity);
    REQUIRE(std::isfinite(objective.energy(2 * cube.rest)));
}
