// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/random.h"
#include "ndg/deform/nearest_rotations.h"
#include "ndg/geometry/rotation.h"

#include <catch2/catch.hpp>

#include <Eigen/LU>
#include <Eigen/SVD>

using namespace ndg;

namespace {

using Matrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Eigen::Matrix3d by_svd(const Eigen::Matrix3d& f)
{
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Vector3d signs(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
    return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

Eigen::Matrix3d row_of(const Gradients& rows, Eigen::Index p)
{
    return Eigen::Map<const Matrix3>(rows.row(p).data());
}

Eigen::Matrix3d turn(Random& random)
{
    return rotation_of(Eigen::Vector3d(random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-3, 3)));
}

Eigen::Matrix3d noise(Random& random)
{
    Eigen::Matrix3d matrix;
    for (int i = 0; i < 9; ++i) matrix.data()[i] = random.normal();
    return matrix;
}

void require_rotations(const Gradients& fitted)
{
    for (Eigen::Index p = 0; p < fitted.rows(); ++p) {
        const Eigen::Matrix3d r = row_of(fitted, p);
        REQUIRE((r.transpose() * r - Eigen::Matrix3d::Identity()).norm() < 2e-6);
        REQUIRE(r.determinant() > 0.99);
    }
}

}  // namespace

TEST_CASE("The nearest rotation of a stretched rotation is that of the singular value decomposition")
{
    Random random(3, "rotations");
    constexpr int count = 1003;  // not a multiple of the lanes
    Gradients gradients(count, 9);
    for (int p = 0; p < count; ++p) {
        Eigen::Matrix3d stretch = noise(random) * 0.15;
        stretch += Eigen::Matrix3d::Identity();
        Eigen::Map<Matrix3>(gradients.row(p).data()) = turn(random) * stretch * (p % 7 == 0 ? 40.0 : 1.0);
    }
    const Gradients fitted = nearest_rotations(gradients);
    require_rotations(fitted);
    for (int p = 0; p < count; ++p) REQUIRE((row_of(fitted, p) - by_svd(row_of(gradients, p))).norm() < 1e-5);
}

TEST_CASE("No rotation is nearer, whether a matrix is inverted, flat or anything else")
{
    Random random(4, "matrices");
    constexpr int count = 2000;
    Gradients gradients(count, 9);
    for (int p = 0; p < count; ++p) {
        Eigen::Matrix3d matrix = noise(random);
        // Flat ones, lines, points turned inside out, and a point.
        if (p % 5 == 1) matrix.col(2) = matrix.col(0);
        if (p % 5 == 2) matrix.rightCols<2>() = matrix.col(0) * Eigen::RowVector2d(2, -1);
        if (p % 5 == 3) matrix = -turn(random);
        if (p == 4) matrix.setZero();
        Eigen::Map<Matrix3>(gradients.row(p).data()) = matrix;
    }
    const Gradients fitted = nearest_rotations(gradients);
    require_rotations(fitted);
    int inverted = 0;
    for (int p = 0; p < count; ++p) {
        const Eigen::Matrix3d f = row_of(gradients, p);
        inverted += f.determinant() < -1e-3;
        const double distance = (f - row_of(fitted, p)).squaredNorm(), least = (f - by_svd(f)).squaredNorm();
        REQUIRE(distance <= least + 1e-5 * (1 + f.squaredNorm()));
    }
    REQUIRE(inverted > 300);
}

TEST_CASE("A rotation is its own nearest, and the identity exactly so")
{
    Random random(5, "own");
    Gradients gradients(17, 9);
    for (Eigen::Index p = 0; p < gradients.rows(); ++p) {
        // Half turns are where quaternions have no real part.
        const double angle = p < 6 ? EIGEN_PI : random.uniform(0, 3);
        Eigen::Map<Matrix3>(gradients.row(p).data()) =
            rotation_of(angle * Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized());
    }
    Eigen::Map<Matrix3>(gradients.row(16).data()).setIdentity();
    const Gradients fitted = nearest_rotations(gradients);
    CHECK((fitted - gradients).cwiseAbs().maxCoeff() < 1e-6);
    CHECK(row_of(fitted, 16) == Eigen::Matrix3d::Identity());
}
