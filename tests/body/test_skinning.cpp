// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/skinning.h"
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/core/threads.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

using namespace ndg;

namespace {

constexpr double pi = 3.14159265358979323846;

Eigen::Isometry3d motion(double angle, const Eigen::Vector3d& axis, const Eigen::Vector3d& shift = {0, 0, 0})
{
    Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
    result.linear() = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
    result.translation() = shift;
    return result;
}

RowMatrix random_dense(int rows, int cols)
{
    Random random(3, "weights");
    RowMatrix dense(rows, cols);
    for (Eigen::Index i = 0; i < dense.size(); ++i) dense.data()[i] = random.uniform();
    return dense;
}

std::vector<Eigen::Isometry3d> random_motions(int count)
{
    Random random(4, "motions");
    std::vector<Eigen::Isometry3d> motions;
    for (int j = 0; j < count; ++j) {
        motions.push_back(motion(random.uniform(-1.0, 1.0), {random.normal(), random.normal(), random.normal()},
                                 {random.normal(), random.normal(), random.normal()}));
    }
    return motions;
}

}  // namespace

TEST_CASE("The eight largest weights are kept and sum to one", "[skinning]")
{
    RowMatrix dense = RowMatrix::Zero(2, 10);
    dense.row(0) << 1, 2, 3, 4, 5, 6, 7, 8, 9, 10;
    dense(1, 7) = 0.25;
    const SkinningWeights weights = sparsify_weights(dense);
    CHECK(weights.joints(0, 0) == 9);
    CHECK(weights.joints(0, 7) == 2);
    CHECK(weights.weights(0, 0) == Approx(10.0 / 52.0));
    CHECK(weights.weights.row(0).sum() == Approx(1.0).margin(1e-15));
    CHECK(weights.joints(1, 0) == 7);
    CHECK(weights.weights(1, 0) == 1.0);
    CHECK(weights.joints.row(1).tail<7>().isZero());
    CHECK(weights.weights.row(1).tail<7>().isZero());

    // Equal weights: the first joints are kept.
    const SkinningWeights equal = sparsify_weights(RowMatrix::Ones(1, 12));
    for (int k = 0; k < 8; ++k) CHECK(equal.joints(0, k) == k);

    dense.row(1).setZero();
    CHECK_THROWS_AS(sparsify_weights(dense), Error);
    dense(1, 3) = -1.0;
    CHECK_THROWS_AS(sparsify_weights(dense), Error);
    dense(1, 3) = std::numeric_limits<double>::quiet_NaN();
    CHECK_THROWS_AS(sparsify_weights(dense), Error);
}

TEST_CASE("Weights of elements are means over their vertices", "[skinning]")
{
    RowMatrix dense = RowMatrix::Zero(3, 4);
    dense << 1, 0, 0, 0, 0.5, 0.5, 0, 0, 0, 0, 0.25, 0.75;
    const SkinningWeights vertices = sparsify_weights(dense);
    RowMatrixI elements(2, 2);
    elements << 0, 1, 1, 2;
    const SkinningWeights weights = element_weights(vertices, elements, 4);
    RowMatrix back = RowMatrix::Zero(2, 4);
    for (Eigen::Index i = 0; i < 2; ++i) {
        for (Eigen::Index k = 0; k < max_influences; ++k) back(i, weights.joints(i, k)) += weights.weights(i, k);
    }
    RowMatrix expected(2, 4);
    expected << 0.75, 0.25, 0, 0, 0.25, 0.25, 0.125, 0.375;
    CHECK((back - expected).cwiseAbs().maxCoeff() < 1e-15);
    elements(1, 1) = 3;
    CHECK_THROWS_AS(element_weights(vertices, elements, 4), Error);
    CHECK_THROWS_AS(element_weights(vertices, elements, 2), Error);

    const SkinningWeights selected = select_weights(vertices, {2, 0, 2});
    CHECK(selected.weights.row(0) == vertices.weights.row(2));
    CHECK(selected.joints.row(1) == vertices.joints.row(0));
    CHECK_THROWS_AS(select_weights(vertices, {3}), Error);
}

TEST_CASE("Linear blend skinning: rest, rigid motion and the mean of two bones", "[skinning]")
{
    constexpr int num_joints = 20;
    const SkinningWeights weights = sparsify_weights(random_dense(200, num_joints));
    const Points rest = random_dense(200, 3);
    CHECK((linear_blend_skinning(rest, weights,
                                 std::vector<Eigen::Isometry3d>(num_joints, Eigen::Isometry3d::Identity())) -
           rest)
              .cwiseAbs()
              .maxCoeff() < 1e-12);

    const Eigen::Isometry3d rigid = motion(1.1, {1, 2, 3}, {0.5, -0.25, 2.0});
    const Points moved = linear_blend_skinning(rest, weights, std::vector<Eigen::Isometry3d>(num_joints, rigid));
    for (Eigen::Index i = 0; i < rest.rows(); ++i) {
        CHECK((moved.row(i).transpose() - rigid * Eigen::Vector3d(rest.row(i).transpose())).norm() < 1e-12);
    }

    // A common rigid motion after any pose commutes with the blend.
    std::vector<Eigen::Isometry3d> motions = random_motions(num_joints), moved_motions;
    for (const Eigen::Isometry3d& each : motions) moved_motions.push_back(rigid * each);
    const Points posed = linear_blend_skinning(rest, weights, motions);
    const Points posed_moved = linear_blend_skinning(rest, weights, moved_motions);
    for (Eigen::Index i = 0; i < rest.rows(); ++i) {
        CHECK((posed_moved.row(i).transpose() - rigid * Eigen::Vector3d(posed.row(i).transpose())).norm() < 1e-12);
    }

    RowMatrix half = RowMatrix::Constant(1, 2, 0.5);
    Points point(1, 3);
    point << 1, 0, 0;
    const Points mean = linear_blend_skinning(point, sparsify_weights(half),
                                              {Eigen::Isometry3d::Identity(), motion(pi / 2.0, {0, 0, 1})});
    CHECK((mean - Points(Eigen::RowVector3d(0.5, 0.5, 0.0))).norm() < 1e-15);

    const int threads = num_threads();
    set_num_threads(1);
    CHECK(linear_blend_skinning(rest, weights, motions) == posed);
    set_num_threads(threads);
    CHECK_THROWS_AS(linear_blend_skinning(rest, select_weights(weights, {0}), motions), Error);
    CHECK_THROWS_AS(linear_blend_skinning(rest, weights, random_motions(3)), Error);
}

TEST_CASE("Blended rotations follow the shorter arc", "[skinning]")
{
    const Eigen::Vector3d z(0, 0, 1);
    const SkinningWeights half = sparsify_weights(RowMatrix::Constant(1, 2, 0.5));
    const auto blend = [&](double a, double b) { return blend_rotations(half, {motion(a, z), motion(b, z)}).front(); };
    CHECK((blend(0.0, pi / 2.0) - motion(pi / 4.0, z).linear()).norm() < 1e-14);
    CHECK((blend(0.4, 0.4) - motion(0.4, z).linear()).norm() < 1e-14);
    // 170 and -170 degrees are 20 degrees apart: without aligned signs their blend would be no rotation at all.
    const double a = 170.0 / 180.0 * pi;
    CHECK((blend(a, -a) - motion(pi, z).linear()).norm() < 1e-14);
    CHECK((blend(-a, a) - motion(pi, z).linear()).norm() < 1e-14);
}

TEST_CASE("Blended rotations are rotations, turn with the world and ignore the order of bones", "[skinning]")
{
    const SkinningWeights weights = sparsify_weights(random_dense(50, 8));
    const std::vector<Eigen::Isometry3d> motions = random_motions(8);
    const auto rotations = blend_rotations(weights, motions);
    const Eigen::Isometry3d world = motion(2.5, {1, -1, 2}, {1, 2, 3});
    std::vector<Eigen::Isometry3d> turned, reversed(motions.rbegin(), motions.rend());
    for (const Eigen::Isometry3d& each : motions) turned.push_back(world * each);
    const auto turned_rotations = blend_rotations(weights, turned);
    SkinningWeights renamed = weights;
    renamed.joints = 7 - renamed.joints.array();
    renamed.joints = renamed.joints.rowwise().reverse().eval();
    renamed.weights = renamed.weights.rowwise().reverse().eval();
    const auto renamed_rotations = blend_rotations(renamed, reversed);
    for (std::size_t i = 0; i < rotations.size(); ++i) {
        CHECK((rotations[i] * rotations[i].transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-14);
        CHECK(rotations[i].determinant() > 0.0);
        CHECK((turned_rotations[i] - world.linear() * rotations[i]).norm() < 1e-13);
        CHECK((renamed_rotations[i] - rotations[i]).norm() < 1e-13);
    }
}
