// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/geometry/prism.h"
#include "ndg/geometry/tetrahedra.h"

#include <catch2/catch.hpp>

#include <array>
#include <cmath>

using namespace ndg;

namespace {

/// Right prism over an equilateral triangle of edge 1, height 1, outer triangle on top.
PrismVertices ideal_prism()
{
    const double h = std::sqrt(3.0) / 2.0;
    PrismVertices prism;
    prism << 0, 0, 1, 1, 0, 1, 0.5, h, 1, 0, 0, 0, 1, 0, 0, 0.5, h, 0;
    return prism;
}

PrismVertices random_prism(std::uint64_t index, double noise = 0.25)
{
    Random random(11, "prism", index);
    PrismVertices prism = ideal_prism();
    for (int i = 0; i < 18; ++i) prism.data()[i] += random.uniform(-noise, noise);
    return prism;
}

Eigen::Matrix3d random_matrix(std::uint64_t index)
{
    Random random(12, "matrix", index);
    Eigen::Matrix3d matrix;
    for (int i = 0; i < 9; ++i) matrix.data()[i] = random.uniform(-1, 1);
    return matrix + 2.0 * Eigen::Matrix3d::Identity();
}

double tet(const PrismVertices& p, int a, int b, int c, int d)
{
    return tetrahedron_volume(p.row(a), p.row(b), p.row(c), p.row(d));
}

/// Volume by splitting every bilinear side along a diagonal: the mean of the two diagonals is exact for a bilinear
/// patch, and the divergence theorem makes the sides independent of each other. Derived without the Jacobian.
double volume_by_surface(const PrismVertices& p)
{
    const Eigen::RowVector3d centre = p.colwise().mean();
    const auto cone = [&](int a, int b, int c) {
        return tetrahedron_volume(centre.transpose(), p.row(a).transpose(), p.row(b).transpose(), p.row(c).transpose());
    };
    double volume = cone(0, 1, 2) + cone(3, 5, 4);
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        // Outward side: inner i, inner j, outer j, outer i.
        const double one = cone(3 + i, 3 + j, j) + cone(3 + i, j, i);
        const double other = cone(3 + i, 3 + j, i) + cone(3 + j, j, i);
        volume += 0.5 * (one + other);
    }
    return volume;
}

Eigen::Matrix3d deformation_gradient(const PrismVertices& rest, const PrismVertices& deformed)
{
    return (prism_gradient_operator(rest) * deformed).transpose();
}

}  // namespace

TEST_CASE("prism: shape functions interpolate and sum to one")
{
    const PrismVertices prism = random_prism(0);
    const std::array<Eigen::Vector3d, 6> corners{{{1, 0, 1}, {0, 1, 1}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}}};
    for (int i = 0; i < 6; ++i) {
        const auto& c = corners[i];
        CHECK((prism_point(prism, c[0], c[1], c[2]) - prism.row(i)).norm() < 1e-14);
    }
    CHECK(prism_shape_functions(0.2, 0.5, 0.7).sum() == Approx(1.0).margin(1e-15));
}

TEST_CASE("prism: Jacobian matches finite differences of the map")
{
    const PrismVertices prism = random_prism(1);
    const Eigen::Vector3d at(0.2, 0.3, 0.6);
    const Eigen::Matrix3d jacobian = prism_jacobian(prism, at[0], at[1], at[2]);
    const double step = 1e-6;
    for (int axis = 0; axis < 3; ++axis) {
        Eigen::Vector3d high = at;
        Eigen::Vector3d low = at;
        high[axis] += step;
        low[axis] -= step;
        const Eigen::RowVector3d slope =
            (prism_point(prism, high[0], high[1], high[2]) - prism_point(prism, low[0], low[1], low[2])) / (2 * step);
        CHECK((jacobian.col(axis).transpose() - slope).norm() < 1e-9);
    }
}

TEST_CASE("prism: volume of known prisms and its sign")
{
    PrismVertices prism = ideal_prism();
    CHECK(prism_volume(prism) == Approx(std::sqrt(3.0) / 4.0).epsilon(1e-14));
    // VTK_WEDGE order: swapping outer and inner triangle turns the prism inside out.
    PrismVertices swapped;
    swapped << prism.bottomRows(3), prism.topRows(3);
    CHECK(prism_volume(swapped) == Approx(-std::sqrt(3.0) / 4.0).epsilon(1e-14));
    // A tapered prism (frustum): V = h/3 (A + sqrt(A a) + a), with the top scaled by one half.
    for (int i = 0; i < 3; ++i) prism.row(i).head<2>() *= 0.5;
    const double area = std::sqrt(3.0) / 4.0;
    CHECK(prism_volume(prism) == Approx(area * (1.0 + 0.5 + 0.25) / 3.0).epsilon(1e-14));
}

TEST_CASE("prism: volume equals the mean over diagonals of tetrahedral decompositions")
{
    for (std::uint64_t index = 0; index < 20; ++index) {
        const PrismVertices prism = random_prism(index, 0.6);
        CHECK(prism_volume(prism) == Approx(volume_by_surface(prism)).margin(1e-14));
        // Two decompositions into three tetrahedra with opposite diagonals on all three sides.
        const double one = tet(prism, 3, 4, 5, 0) + tet(prism, 4, 5, 0, 1) + tet(prism, 5, 0, 1, 2);
        const double other = tet(prism, 3, 4, 5, 2) + tet(prism, 3, 4, 2, 1) + tet(prism, 3, 0, 1, 2);
        CHECK(prism_volume(prism) == Approx(0.5 * (one + other)).margin(1e-14));
    }
}

TEST_CASE("prism: volume agrees with high-order quadrature of det J")
{
    // Composite midpoint rules converge to the integral whatever the degree.
    const PrismVertices prism = random_prism(3, 0.4);
    constexpr int n = 60;
    double sum = 0.0;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n - i; ++j) {
            for (int k = 0; k < n; ++k) {
                const double xi = (k + 0.5) / n;
                const double a = (i + 1.0 / 3.0) / n;
                const double b = (j + 1.0 / 3.0) / n;
                sum += prism_jacobian(prism, a, b, xi).determinant();
                if (j < n - i - 1) {
                    sum += prism_jacobian(prism, a + 1.0 / (3.0 * n), b + 1.0 / (3.0 * n), xi).determinant();
                }
            }
        }
    }
    CHECK(prism_volume(prism) == Approx(sum * 0.5 / (n * n) / n).epsilon(1e-4));
}

TEST_CASE("prism: volume gradient matches finite differences")
{
    PrismVertices prism = random_prism(4, 0.4);
    const PrismVertices gradient = prism_volume_gradient(prism);
    const double step = 1e-5;
    for (int i = 0; i < 18; ++i) {
        const double value = prism.data()[i];
        prism.data()[i] = value + step;
        const double high = prism_volume(prism);
        prism.data()[i] = value - step;
        const double low = prism_volume(prism);
        prism.data()[i] = value;
        CHECK(gradient.data()[i] == Approx((high - low) / (2 * step)).margin(1e-9));
    }
    // Moving the whole prism keeps its volume.
    CHECK(gradient.colwise().sum().norm() < 1e-14);
}

TEST_CASE("prism: volume Hessian matches finite differences of the gradient")
{
    PrismVertices prism = random_prism(5, 0.4);
    const Eigen::Matrix<double, 18, 18> hessian = prism_volume_hessian(prism);
    REQUIRE(hessian.norm() > 1e-3);
    const double step = 1e-5;
    for (int a = 0; a < 6; ++a) {
        for (int c = 0; c < 3; ++c) {
            const double value = prism(a, c);
            prism(a, c) = value + step;
            const PrismVertices high = prism_volume_gradient(prism);
            prism(a, c) = value - step;
            const PrismVertices low = prism_volume_gradient(prism);
            prism(a, c) = value;
            const PrismVertices column = (high - low) / (2 * step);
            for (int b = 0; b < 6; ++b) {
                const Eigen::Vector3d difference = hessian.block<3, 1>(3 * b, 3 * a + c) - column.row(b).transpose();
                CHECK(difference.norm() < 1e-9);
            }
        }
    }
}

TEST_CASE("prism: the gradient operator reproduces affine maps")
{
    for (std::uint64_t index = 0; index < 10; ++index) {
        const PrismVertices rest = random_prism(index);
        const Eigen::Matrix3d map = random_matrix(index);
        PrismVertices deformed = rest * map.transpose();
        deformed.rowwise() += Eigen::RowVector3d(3.0, -2.0, 5.0);
        CHECK((deformation_gradient(rest, deformed) - map).norm() < 1e-12);
        const Eigen::Matrix3d rotation =
            Eigen::AngleAxisd(0.3 + static_cast<double>(index), Eigen::Vector3d(1, -2, 0.5).normalized())
                .toRotationMatrix();
        CHECK((deformation_gradient(rest, rest * rotation.transpose()) - rotation).norm() < 1e-12);
    }
}

TEST_CASE("prism: the gradient operator is the least-squares optimum of supplement equation 3")
{
    // Independent derivation: a weighted fit over many sample points of the reference prism. The rest prism and the
    // deformed one both vary, so the fit is not exact and the weights matter.
    const PrismVertices rest = random_prism(5);
    const PrismVertices deformed = random_prism(6);
    Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
    Eigen::Matrix<double, 4, 3> right = Eigen::Matrix<double, 4, 3>::Zero();
    // Edge midpoints integrate quadratics over a triangle exactly, Simpson's rule those over [0, 1].
    const std::array<Eigen::Vector2d, 3> midpoints{{{0.5, 0.5}, {0.5, 0.0}, {0.0, 0.5}}};
    const std::array<double, 3> simpson{{1.0, 4.0, 1.0}};
    for (int k = 0; k < 3; ++k) {
        for (const auto& m : midpoints) {
            Eigen::Vector4d x;
            x << prism_point(rest, m[0], m[1], 0.5 * k).transpose(), 1.0;
            const double weight = simpson[k];
            normal += weight * x * x.transpose();
            right += weight * x * prism_point(deformed, m[0], m[1], 0.5 * k);
        }
    }
    const Eigen::Matrix<double, 4, 3> fit = normal.inverse() * right;
    // Supplement equation 5 fixes the translation by the vertex centroids, which is the optimum of equation 3.
    CHECK((deformation_gradient(rest, deformed) - fit.topRows(3).transpose()).norm() < 1e-10);
}

TEST_CASE("prism: the gradient operator is exact for thin prisms and invariant")
{
    PrismVertices thin = random_prism(7, 0.1);
    thin.col(2) *= 1e-4;
    const Eigen::Matrix3d map = random_matrix(7);
    CHECK((deformation_gradient(thin, thin * map.transpose()) - map).norm() < 1e-10);

    const PrismVertices rest = random_prism(8);
    const PrismVertices deformed = random_prism(9);
    const PrismGradient gradient = prism_gradient_operator(rest);
    CHECK((gradient * Eigen::Matrix<double, 6, 1>::Ones()).norm() < 1e-13);
    const PrismVertices moved = rest.rowwise() + Eigen::RowVector3d(1.0, 2.0, -3.0);
    CHECK((prism_gradient_operator(moved) - gradient).norm() < 1e-12);
    CHECK((prism_gradient_operator(2.0 * rest) - 0.5 * gradient).norm() < 1e-12);
    // Rotating the deformed prism rotates F.
    const Eigen::Matrix3d rotation = Eigen::AngleAxisd(1.1, Eigen::Vector3d::UnitX()).toRotationMatrix();
    CHECK(
        (deformation_gradient(rest, deformed * rotation.transpose()) - rotation * deformation_gradient(rest, deformed))
            .norm() < 1e-12);
}

TEST_CASE("prism: a flat prism has no gradient operator")
{
    PrismVertices flat = ideal_prism();
    flat.col(2).setZero();
    CHECK_THROWS_AS(prism_gradient_operator(flat), Error);
    CHECK_THROWS_AS(prism_gradient_operator(PrismVertices::Zero()), Error);
    flat.col(2).setConstant(std::nan(""));
    CHECK_THROWS_AS(prism_gradient_operator(flat), Error);

    Points vertices(12, 3);
    vertices << ideal_prism(), flat;
    Prisms prisms(2, 6);
    prisms << 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11;
    CHECK_THROWS_WITH(gradient_operator(vertices, prisms), Catch::Contains("prism 1"));
}

TEST_CASE("prism: the stacked operator gives each prism's gradient")
{
    Points rest(9, 3);
    rest.topRows(6) = random_prism(10);
    rest.bottomRows(3) = rest.topRows(3).rowwise() + Eigen::RowVector3d(0.1, 0.2, 1.0);
    Prisms prisms(2, 6);
    prisms << 0, 1, 2, 3, 4, 5, 6, 7, 8, 0, 1, 2;
    Points deformed = rest;
    Random random(13, "stack");
    for (int i = 0; i < 27; ++i) deformed.data()[i] += random.uniform(-0.2, 0.2);
    const auto gradients = deformation_gradients(gradient_operator(rest, prisms), deformed);
    REQUIRE(gradients.rows() == 2);
    for (int p = 0; p < 2; ++p) {
        const Eigen::Matrix3d expected =
            deformation_gradient(gather_prism(rest, prisms, p), gather_prism(deformed, prisms, p));
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) CHECK(gradients(p, 3 * i + j) == Approx(expected(i, j)).margin(1e-13));
        }
    }
    const Eigen::VectorXd volumes = prism_volumes(rest, prisms);
    CHECK(volumes[1] == Approx(prism_volume(gather_prism(rest, prisms, 1))));
}

TEST_CASE("prism: smallest Jacobians")
{
    const PrismVertices prism = ideal_prism();
    CHECK(prism_min_scaled_jacobian(prism) == Approx(1.0).epsilon(1e-14));
    CHECK(prism_min_scaled_jacobian(3.0 * prism) == Approx(1.0).epsilon(1e-14));
    CHECK(prism_min_jacobian(prism) == Approx(std::sqrt(3.0) / 2.0).epsilon(1e-14));
    // One outer corner pushed below the inner triangle: positive volume, invalid all the same.
    PrismVertices dented = prism;
    dented(0, 2) = -0.2;
    CHECK(prism_volume(dented) > 0.0);
    CHECK(prism_min_jacobian(dented) < 0.0);
    CHECK(prism_min_scaled_jacobian(dented) < 0.0);
    PrismVertices collapsed = prism;
    collapsed.row(0) = collapsed.row(3);
    CHECK(prism_min_scaled_jacobian(collapsed) == 0.0);
}

TEST_CASE("prism: local coordinates invert the map")
{
    Random random(14, "coordinates");
    for (std::uint64_t index = 0; index < 20; ++index) {
        const PrismVertices prism = random_prism(index, 0.15);
        double alpha = random.uniform(0, 1);
        double beta = random.uniform(0, 1);
        if (alpha + beta > 1.0) {
            alpha = 1.0 - alpha;
            beta = 1.0 - beta;
        }
        const double xi = random.uniform(0, 1);
        const PrismCoordinates found = prism_coordinates(prism, prism_point(prism, alpha, beta, xi));
        REQUIRE(found.converged);
        CHECK(found.alpha == Approx(alpha).margin(1e-10));
        CHECK(found.beta == Approx(beta).margin(1e-10));
        CHECK(found.xi == Approx(xi).margin(1e-10));
    }
    // A point outside has coordinates outside; a flat prism has none for a point off its plane.
    const PrismCoordinates above = prism_coordinates(ideal_prism(), Eigen::RowVector3d(0.5, 0.3, 1.5));
    CHECK(above.converged);
    CHECK(above.xi == Approx(1.5));
    PrismVertices flat = ideal_prism();
    flat.col(2).setZero();
    CHECK_FALSE(prism_coordinates(flat, Eigen::RowVector3d(0.5, 0.3, 1.0)).converged);
}

TEST_CASE("prism: a corner folded over is counted though the volume is positive")
{
    // The unit right prism, twice; of the second one outer vertex is pushed across the opposite side of its triangle.
    Points vertices(12, 3);
    vertices.topRows(6) << 1, 0, 1, 0, 1, 1, 0, 0, 1, 1, 0, 0, 0, 1, 0, 0, 0, 0;
    vertices.bottomRows(6) = vertices.topRows(6);
    vertices.row(8) << 0.6, 0.6, 1;
    Prisms prisms(2, 6);
    prisms << 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11;
    const InvertedPrisms count = count_inverted_prisms(vertices, prisms);
    CHECK(count.by_volume == 0);
    CHECK(count.at_corners == 1);
    const PrismVertices whole = gather_prism(vertices, prisms, 0), folded = gather_prism(vertices, prisms, 1);
    CHECK(prism_min_corner_jacobian(whole) == Approx(1));
    // (x0 - x2) x (x1 - x2) . (x0 - x3) of the outer triangle: (0.4, -0.6, 0) x (-0.6, 0.4, 0) = (0, 0, -0.2).
    CHECK(prism_min_corner_jacobian(folded) == Approx(-0.2));
    for (int corner = 0; corner < 6; ++corner) {
        const double step = 1e-6;
        const PrismVertices gradient = prism_corner_jacobian_gradient(folded, corner);
        const auto hessian = prism_corner_jacobian_hessian(folded, corner);
        for (int k = 0; k < 18; ++k) {
            PrismVertices plus = folded, minus = folded;
            plus(k / 3, k % 3) += step;
            minus(k / 3, k % 3) -= step;
            CHECK(gradient(k / 3, k % 3) ==
                  Approx((prism_corner_jacobian(plus, corner) - prism_corner_jacobian(minus, corner)) / (2 * step))
                      .margin(1e-8));
            const PrismVertices change =
                (prism_corner_jacobian_gradient(plus, corner) - prism_corner_jacobian_gradient(minus, corner)) /
                (2 * step);
            for (int l = 0; l < 18; ++l) CHECK(hessian(l, k) == Approx(change(l / 3, l % 3)).margin(1e-8));
        }
    }
    vertices.row(8) << 3, 3, 1;
    CHECK(count_inverted_prisms(vertices, prisms).by_volume == 1);
}
