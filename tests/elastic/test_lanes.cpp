// SPDX-License-Identifier: Apache-2.0
// Kernels of four elements at a time against one element's formulas and the general eigen solver.
#include "ndg/core/random.h"
#include "ndg/elastic/elements.h"
#include "ndg/elastic/flesh_lanes.h"
#include "ndg/elastic/neo_hookean.h"
#include "ndg/elastic/neo_hookean_lanes.h"
#include "ndg/elastic/projection.h"
#include "ndg/elastic/skin_lanes.h"
#include "ndg/geometry/triangle_mesh.h"

#include <catch2/catch.hpp>

#include <Eigen/Dense>

#include <cmath>
#include <numeric>

using namespace ndg;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

template <int Rows, std::size_t Size>
Eigen::Matrix<double, Rows, 1> vector_of(const LaneVector<Size>& lanes, std::size_t lane)
{
    Eigen::Matrix<double, Rows, 1> result;
    for (int k = 0; k < Rows; ++k) result(k) = lanes.values[num_lanes * static_cast<std::size_t>(k) + lane];
    return result;
}

template <std::size_t Size>
Eigen::MatrixXd matrix_of(const LaneBlocks<Size>& lanes, std::size_t lane)
{
    constexpr int rows = 3 * static_cast<int>(Size);
    Eigen::MatrixXd full(rows, rows);
    for (std::size_t a = 0; a < Size; ++a) {
        for (std::size_t b = 0; b <= a; ++b) {
            for (std::size_t k = 0; k < 9; ++k) {
                const int row = static_cast<int>(3 * a + k % 3), column = static_cast<int>(3 * b + k / 3);
                const double value = lanes.values[num_lanes * (LaneBlocks<Size>::at(a, b) + k) + lane];
                full(row, column) = value;
                if (a != b) full(column, row) = value;
            }
        }
    }
    return full;
}

template <typename A, typename B>
void require_close(const A& value, const B& expected, double relative)
{
    REQUIRE(expected.norm() > 0);
    REQUIRE((value - expected).norm() <= relative * expected.norm());
}

Vector3d random_vector(Random& random, double size)
{
    return Vector3d(random.normal(), random.normal(), random.normal()) * size;
}

Matrix3d random_rotation(Random& random)
{
    return Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal())
        .normalized()
        .toRotationMatrix();
}

/// A hinge opened by `angle`, its wings `heights` high with their feet at shares `feet` of the edge, anywhere.
Hinge make_hinge(double angle, const std::array<double, 2>& heights, const std::array<double, 2>& feet, Random& random)
{
    const double length = 0.02;
    Hinge hinge;
    hinge.x0 = Vector3d::Zero();
    hinge.x1 = Vector3d(0, length, 0);
    hinge.left = Vector3d(-heights[0] * std::cos(angle / 2), feet[0] * length, -heights[0] * std::sin(angle / 2));
    hinge.right = Vector3d(heights[1] * std::cos(angle / 2), feet[1] * length, -heights[1] * std::sin(angle / 2));
    const Matrix3d turn = random_rotation(random);
    const Vector3d shift = random_vector(random, 1);
    for (Vector3d* x : {&hinge.x0, &hinge.x1, &hinge.left, &hinge.right}) *x = turn * *x + shift;
    return hinge;
}

/// Random hinges, then flat ones, folded ones, slivers, hinges at their rest angle, and fading ones.
std::vector<std::pair<Hinge, HingeRest>> hinges()
{
    std::vector<std::pair<Hinge, HingeRest>> result;
    Random random(5, "hinges");
    const auto add = [&](double angle, std::array<double, 2> heights, std::array<double, 2> feet, double rest_angle,
                         double rest_height) {
        const double area = 0.5 * 0.02 * rest_height;
        result.emplace_back(make_hinge(angle, heights, feet, random), HingeRest{rest_angle, 2.5, area, 1.1 * area});
    };
    for (int i = 0; i < 40; ++i) {
        add(random.uniform(-2, 2), {random.uniform(0.005, 0.03), random.uniform(0.005, 0.03)},
            {random.uniform(-0.5, 1.5), random.uniform(-0.5, 1.5)}, random.uniform(-1, 1), 0.015);
    }
    for (const double rest : {-0.6, -1e-3, 1e-7, 0.3}) {
        add(0, {0.015, 0.015}, {0.5, 0.5}, rest, 0.015);
        add(0, {0.015, 0.02}, {0.2, 0.9}, rest, 0.015);
        add(2.967, {0.015, 0.01}, {0.4, 0.6}, rest, 0.015);
        add(-2.967, {0.015, 0.015}, {0.5, 0.5}, rest, 0.015);
        add(0.7, {1e-4, 0.02}, {0.5, 3}, rest, 5e-4);
        add(0.2, {2e-3, 2e-3}, {20, -20}, rest, 0.01);
        add(0.4, {0.012, 0.016}, {0.3, 0.6}, 0.4, 0.015);
        add(0.9, {5e-4, 0.016}, {0.3, 0.6}, rest, 0.015);
        add(0.9, {5e-4, 9e-4}, {0.3, 0.6}, rest, 0.015);
    }
    return result;
}

constexpr double stretch_stiffness = 3e-2;

/// Elements of vertices of their own: element i has the i th `Size` of them.
template <std::size_t Size>
struct Corners {
    std::array<int, Size * num_lanes> vertices;
    Corners() { std::iota(vertices.begin(), vertices.end(), 0); }
};

template <class Rest, std::size_t Size>
ElementBatch<Rest> batch_of(const std::array<Rest, num_lanes>& rests, const Corners<Size>& corners)
{
    ElementBatch<Rest> batch;
    batch.count = num_lanes;
    for (std::size_t i = 0; i < num_lanes; ++i) {
        batch.places[i] = static_cast<int>(i);
        batch.corners[i] = &corners.vertices[Size * i];
        batch.rests[i] = &rests[i];
    }
    return batch;
}

/// Stretching and bending as one 12 x 12 matrix.
Matrix12 joined(const Matrix12& bend, const Matrix6& stretch)
{
    Matrix12 sum = bend;
    sum.topLeftCorner<6, 6>() += stretch_stiffness * stretch;
    return sum;
}

}  // namespace

TEST_CASE("Four hinges at a time are as one at a time, their clamp as the general eigen solver's")
{
    const auto all = hinges();
    int indefinite = 0, faded = 0, compressed = 0;
    for (std::size_t begin = 0; begin + num_lanes <= all.size(); begin += num_lanes) {
        Points positions(4 * num_lanes, 3);
        std::array<SkinEdgeRest, num_lanes> rests;
        Corners<4> corners;
        for (std::size_t i = 0; i < num_lanes; ++i) {
            const auto& [hinge, rest] = all[begin + i];
            const int row = static_cast<int>(4 * i);
            positions.row(row) = hinge.x0.transpose();
            positions.row(row + 1) = hinge.x1.transpose();
            positions.row(row + 2) = hinge.left.transpose();
            positions.row(row + 3) = hinge.right.transpose();
            rests[i] = {i % 2 == 0 ? 0.017 : 0.025, stretch_stiffness, rest};
        }
        const SkinLanes lanes(positions, batch_of(rests, corners));
        const auto [stretch_forces, bend_forces] = lanes.forces();
        HingeBlocks exact, projected, gauss_newton;
        lanes.hessian(exact);
        lanes.projected_hessian(projected);
        lanes.gauss_newton_hessian(gauss_newton);
        for (std::size_t i = 0; i < num_lanes; ++i) {
            const auto& [hinge, rest] = all[begin + i];
            const double length = rests[i].length;
            REQUIRE(lanes.energy()[i] ==
                    Approx(stretch_stiffness * stretch_energy(hinge.x0, hinge.x1, length) + bend_energy(hinge, rest))
                        .epsilon(1e-10));
            REQUIRE(lanes.stability()[i] == Approx(bend_stability(hinge, rest)).epsilon(1e-8).margin(1e-8));
            const Vector12 expected_forces = bend_gradient(hinge, rest);
            // A wing of a tenth of a millimetre has its height to a relative 1e-11 at a metre from the origin.
            REQUIRE((vector_of<12>(bend_forces, i) - expected_forces).norm() < 1e-8 * expected_forces.norm() + 1e-8);
            const Vector6 stretch = stretch_stiffness * stretch_gradient(hinge.x0, hinge.x1, length);
            require_close(vector_of<6>(stretch_forces, i), stretch, 1e-12);

            const Matrix12 hessian = bend_hessian(hinge, rest);
            const Matrix6 spring = stretch_hessian(hinge.x0, hinge.x1, length);
            const Matrix6 clamped_spring = stretch_projected_hessian(hinge.x0, hinge.x1, length);
            compressed += (spring - clamped_spring).norm() > 0;
            require_close(matrix_of(exact, i), joined(hessian, spring), 1e-9);
            require_close(matrix_of(gauss_newton, i), joined(bend_gauss_newton_hessian(hinge, rest), clamped_spring),
                          1e-9);
            const Matrix12 clamped = clamp_eigenvalues<12>(hessian);
            indefinite += (clamped - hessian).norm() > 1e-2 * hessian.norm();
            faded += lanes.stability()[i] < -1e8;
            require_close(matrix_of(projected, i), joined(clamped, clamped_spring), 1e-9);
        }
    }
    REQUIRE(indefinite > 20);
    REQUIRE(faded == 8);
    REQUIRE(compressed > 20);
}

TEMPLATE_TEST_CASE("Four elements of flesh at a time are as one at a time, their clamp as the general eigen solver's",
                   "", PrismElement, TetrahedronElement)
{
    constexpr int size = TestType::num_corners, rows = 3 * size;
    using Kernel = FleshLanes<NeoHookeanLanes, size>;
    Random random(9, "prisms");
    PrismVertices prism;
    prism << 0.02, 0, 0.011, -0.01, 0.016, 0.01, -0.01, -0.017, 0.009, 0.019, 0.001, 0, -0.011, 0.014, 0, -0.009,
        -0.015, 0.001;
    Eigen::Matrix<double, size, 3> shape = prism.bottomRows<size>();
    if (size == 4) shape.row(0).swap(shape.row(1));
    const double volume = TestType::volume(shape);
    REQUIRE(volume > 0);
    std::vector<Matrix3d> deformations;
    for (int i = 0; i < 40; ++i) {
        Matrix3d f = Matrix3d::Identity();
        const double spread = i < 20 ? 0.15 : 0.8;
        for (int k = 0; k < 9; ++k) f(k) += spread * random.normal();
        deformations.push_back(f);
    }
    // Equal, vanishing, tiny and negative stretches; with one stretch or none the singular vectors are not unique.
    for (const Vector3d& s :
         {Vector3d(1, 1, 1), Vector3d(1, 1, -1), Vector3d(1.3, 1.3, 1.3), Vector3d(0.5, 0.5, 0.5), Vector3d(1, 1, 0),
          Vector3d(2, 0.4, 0), Vector3d(1, 1e-3, 1e-3), Vector3d(1, 1e-4, 1e-9), Vector3d(1, 1e-7, 1e-9),
          Vector3d(0.7, 0, 0), Vector3d(1e-9, 1e-9, 1e-9), Vector3d(2, 2, 0.1)}) {
        deformations.push_back(random_rotation(random) * s.asDiagonal() * random_rotation(random));
    }
    deformations.insert(deformations.end(), {Matrix3d::Identity(), 1.5 * Matrix3d::Identity(), Matrix3d::Zero(),
                                             Vector3d(-1, 0.2, 1).asDiagonal().toDenseMatrix()});
    int indefinite = 0, inverted = 0, stretches = 0;
    for (std::size_t begin = 0; begin < deformations.size(); begin += num_lanes) {
        Points positions(size * num_lanes, 3);
        std::array<typename Kernel::Rest, num_lanes> rests;
        Corners<size> corners;
        for (std::size_t i = 0; i < num_lanes; ++i) {
            rests[i].gradient = TestType::gradient_operator(shape);
            rests[i].weight = 1.7 * volume;
            rests[i].material = lame_parameters(i % 2 == 0 ? 45e3 : 15e3, 0.47);
            // The averaged gradient does not see the prism's hourglass modes.
            Eigen::Matrix<double, size, 3> placed = shape * deformations[begin + i].transpose();
            if (i % 2 == 1) placed.row(1) += 0.002 * random_vector(random, 1).transpose();
            positions.middleRows<size>(static_cast<int>(size * i)) = placed;
        }
        const Kernel lanes(positions, batch_of(rests, corners));
        const auto [forces] = lanes.forces();
        LaneBlocks<size> exact, projected;
        lanes.hessian(exact);
        lanes.semidefinite_hessian(HessianKind::projected, projected);
        for (std::size_t i = 0; i < num_lanes; ++i) {
            const auto& element = rests[i];
            const Eigen::Matrix<double, size, 3> placed = positions.middleRows<size>(static_cast<int>(size * i));
            const Matrix3d f = placed.transpose() * element.gradient.transpose();
            REQUIRE(lanes.energy()[i] ==
                    Approx(element.weight * neo_hookean_energy(f, element.material)).epsilon(1e-10).margin(1e-12));
            // Equal singular values leave eight digits of the largest to either of the two direct formulas.
            REQUIRE(lanes.stability()[i] ==
                    Approx(neo_hookean_stability(f, element.material)).epsilon(1e-7).margin(1e-6));
            // Coordinates of F from those of the corners.
            Eigen::Matrix<double, 9, rows> to_f = Eigen::Matrix<double, 9, rows>::Zero();
            for (int a = 0; a < size; ++a) {
                for (int j = 0; j < 3; ++j)
                    to_f.template block<3, 3>(3 * j, 3 * a).diagonal().array() = element.gradient(j, a);
            }
            const Matrix3d stress = neo_hookean_stress(f, element.material);
            const Eigen::Matrix<double, rows, 1> expected =
                element.weight * to_f.transpose() * Eigen::Map<const Eigen::Matrix<double, 9, 1>>(stress.data());
            REQUIRE((vector_of<rows>(forces, i) - expected).norm() < 1e-12 * expected.norm() + 1e-12);
            const Matrix9 hessian = neo_hookean_hessian(f, element.material);
            const Matrix9 clamped = clamp_eigenvalues<9>(hessian);
            require_close(matrix_of(exact, i), element.weight * to_f.transpose() * hessian * to_f, 1e-12);
            require_close(matrix_of(projected, i), element.weight * to_f.transpose() * clamped * to_f, 1e-9);
            indefinite += (clamped - hessian).norm() > 1e-2 * hessian.norm();
            inverted += f.determinant() < 0;
            const Eigen::JacobiSVD<Matrix3d> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
            Eigen::Matrix<double, 9, 3> dyads;
            for (int k = 0; k < 3; ++k) {
                const Matrix3d dyad = svd.matrixU().col(k) * svd.matrixV().col(k).transpose();
                dyads.col(k) = Eigen::Map<const Eigen::Matrix<double, 9, 1>>(dyad.data());
            }
            const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(dyads.transpose() * hessian * dyads);
            stretches += solver.eigenvalues()(0) < 0;
        }
    }
    REQUIRE(indefinite > 10);
    REQUIRE(inverted > 5);
    REQUIRE(stretches > 3);
}

TEST_CASE("One-sided Jacobi gives the absolute value of symmetric matrices")
{
    Random random(4, "jacobi");
    for (int round = 0; round < 20; ++round) {
        std::array<std::array<Lanes, 8>, 8> w{};
        std::array<Eigen::Matrix<double, 8, 8>, num_lanes> expected;
        for (std::size_t i = 0; i < num_lanes; ++i) {
            Eigen::Matrix<double, 8, 8> a;
            for (int k = 0; k < 64; ++k) a(k) = random.normal();
            const Eigen::Matrix<double, 8, 8> q = a.householderQr().householderQ();
            Eigen::Matrix<double, 8, 1> values;
            for (int k = 0; k < 8; ++k) values(k) = (k % 2 == 0 ? 1 : -1) * std::pow(10.0, -round * 0.1 * k);
            if (round == 1) values << 1, -1, 1, -1, 0, 0, 1e-8, 1e-8;
            expected[i] = q * values.cwiseAbs().asDiagonal() * q.transpose();
            const Eigen::Matrix<double, 8, 8> symmetric = q * values.asDiagonal() * q.transpose();
            for (std::size_t k = 0; k < 64; ++k) w[k / 8][k % 8][i] = symmetric(static_cast<int>(k));
        }
        orthogonalise<8>(w);
        for (std::size_t i = 0; i < num_lanes; ++i) {
            Eigen::Matrix<double, 8, 8> sum = Eigen::Matrix<double, 8, 8>::Zero();
            for (const auto& column : w) {
                Eigen::Matrix<double, 8, 1> c;
                for (std::size_t k = 0; k < 8; ++k) c(static_cast<int>(k)) = column[k][i];
                if (c.norm() > 0) sum += c * c.transpose() / c.norm();
            }
            require_close(sum, expected[i], 1e-10);
        }
    }
}
