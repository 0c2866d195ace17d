// SPDX-License-Identifier: Apache-2.0
#include "ndg/body_source/anatomy_field.h"
#include "ndg/body_source/anatomy_fit.h"
#include "ndg/body_source/bodyparts3d.h"
#include "ndg/core/error.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;

namespace {

Points scattered(int count, unsigned seed)
{
    // Low-discrepancy points in [-1, 1]^3: the fractional parts of multiples of irrational numbers.
    Points points(count, 3);
    for (int i = 0; i < count; ++i)
        for (int k = 0; k < 3; ++k) {
            const double value = (i + 1.0 + 17.0 * seed) * std::sqrt(2.0 + 3.0 * k + k * k);
            points(i, k) = 2.0 * (value - std::floor(value)) - 1.0;
        }
    return points;
}

}  // namespace

TEST_CASE("Sphere fit finds a part of a sphere and ignores what hangs on it")
{
    const Eigen::RowVector3d centre(0.1, 0.9, -0.02);
    Points points = scattered(240, 1);
    points.rowwise().normalize();
    for (Eigen::Index i = 0; i < points.rows(); ++i) points(i, 1) = std::abs(points(i, 1));
    points = (0.024 * points).rowwise() + centre;
    const Sphere exact = fit_sphere(points);
    CHECK(exact.radius == Approx(0.024));
    CHECK((exact.centre.transpose() - centre).norm() < 1e-9);

    Points with_neck(points.rows() + 60, 3);
    with_neck << points, (0.01 * scattered(60, 2)).rowwise() + (centre - Eigen::RowVector3d(0, 0.03, 0));
    const Sphere robust = fit_sphere(with_neck);
    CHECK(robust.radius == Approx(0.024).epsilon(0.01));
    CHECK((robust.centre.transpose() - centre).norm() < 3e-4);

    CHECK_THROWS_AS(fit_sphere(points.topRows(3)), Error);
    Points flat = points;
    flat.col(2).setZero();
    CHECK_THROWS_AS(fit_sphere(flat), Error);
}

TEST_CASE("Similarity fit recovers rotation, scale and place")
{
    const Points from = scattered(12, 3);
    const Eigen::Matrix3d rotation =
        Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
    const Eigen::Vector3d shift(0.3, -1.0, 2.0);
    const Points to = (1.7 * from * rotation.transpose()).rowwise() + shift.transpose();
    const Eigen::Affine3d fitted = fit_similarity(from, to);
    CHECK((fitted.linear() - 1.7 * rotation).norm() < 1e-9);
    CHECK((fitted.translation() - shift).norm() < 1e-9);
    CHECK_THROWS_AS(fit_similarity(from.topRows(2), to.topRows(2)), Error);
}

TEST_CASE("A bone's ends go to its joints, with one scale along and one across")
{
    const Eigen::Vector3d a(0.1, 1.3, 0.05), b(0.2, 1.0, 0.07), c(0.2, 1.4, 0.0), d(0.45, 1.2, 0.1);
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitY()).toRotationMatrix();
    const Eigen::Affine3d map = bone_transform(a, b, c, d, turn, 0.9);
    CHECK((map * a - c).norm() < 1e-12);
    CHECK((map * b - d).norm() < 1e-12);
    const Eigen::Vector3d across = (b - a).unitOrthogonal();
    CHECK((map.linear() * across).norm() == Approx(0.9));
    CHECK(std::abs((map.linear() * across).dot(d - c)) < 1e-12);
    CHECK(map.linear().determinant() == Approx(0.81 * (d - c).norm() / (b - a).norm()));
    CHECK_THROWS_AS(bone_transform(a, a, c, d, turn, 0.9), Error);

    const Eigen::Matrix3d frame = frame_along(b - a, Eigen::Vector3d::UnitZ());
    CHECK((frame.transpose() * frame).isIdentity(1e-12));
    CHECK(frame.determinant() == Approx(1.0));
    CHECK_THROWS_AS(frame_along(b - a, b - a), Error);
}

TEST_CASE("A displacement field reproduces what smoothness does not oppose")
{
    const Points points = 0.1 * scattered(400, 4);
    const Eigen::VectorXd ones = Eigen::VectorXd::Ones(points.rows());
    SECTION("a translation costs nothing")
    {
        Points wanted(points.rows(), 3);
        wanted.rowwise() = Eigen::RowVector3d(0.01, -0.02, 0.005);
        const DisplacementField field(points, wanted, ones, 0.03, {});
        CHECK((field.at(points) - wanted).cwiseAbs().maxCoeff() < 1e-6);
        CHECK(field.at(Points::Constant(1, 3, 5.0)).isZero());
    }
    SECTION("a linear field bends nothing")
    {
        Eigen::Matrix3d slope;
        slope << 0.02, 0.1, 0, -0.05, 0.03, 0.02, 0, 0.01, -0.04;
        const Points wanted = points * slope;
        const DisplacementField field(points, wanted, ones, 0.03, {0.0, 1.0});
        CHECK((field.at(points) - wanted).cwiseAbs().maxCoeff() < 2e-6);
    }
    SECTION("a push on one point takes its neighbours along and fades")
    {
        Points wanted = Points::Zero(points.rows(), 3);
        Eigen::VectorXd weights = Eigen::VectorXd::Constant(points.rows(), 0.01);
        wanted.row(0) << 0, 0.01, 0;
        weights[0] = 1.0;
        const DisplacementField field(points, wanted, weights, 0.02, {});
        const Points moved = field.at(points);
        CHECK(moved(0, 1) > 0.0005);
        CHECK(moved.cwiseAbs().maxCoeff() <= 0.0101);
        Eigen::Index farthest = 0;
        (points.rowwise() - points.row(0)).rowwise().norm().maxCoeff(&farthest);
        CHECK(moved.row(farthest).norm() < 0.2 * moved(0, 1));
    }
}

TEST_CASE("File names of BodyParts3D say part, FMA id and side")
{
    const BodyPartName femur = parse_body_part_name("FJ838_BP63016_FMA24475_Left_femur.glb");
    CHECK(femur.name == "Left femur");
    CHECK(femur.fma_id == 24475);
    CHECK(femur.side == BodySide::left);
    CHECK(parse_body_part_name("FJ416_BP63675_FMA42398_Set_of_lumbricals_of_right_hand.glb").side == BodySide::right);
    CHECK(parse_body_part_name("FJ829_BP62535_FMA13295_Diaphragm.glb").side == BodySide::middle);
    CHECK_THROWS_AS(parse_body_part_name("femur.glb"), InputError);
    CHECK_THROWS_AS(parse_body_part_name("FJ1_BP2_FMAx_Femur.glb"), InputError);
}
