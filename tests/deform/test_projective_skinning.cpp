// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/random.h"
#include "ndg/deform/gradient_skinning.h"
#include "ndg/deform/projective_skinning.h"
#include "ndg/geometry/prism.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <Eigen/LU>
#include <Eigen/SVD>

using namespace ndg;

namespace {

struct Scene {
    Template tube = test::tube_template(7, 6);
    BodyPoser poser{tube, test::bending};
    RestOperators rest{tube.prisms, tube.rest.volume_vertices};
    PoissonReconstruction poisson{rest, tube.num_wrap_vertices()};

    /// sum_p V_p min_R |F_p - R|^2 by singular values: the nearest rotation takes the smallest of an inverted F by its
    /// negative.
    double energy(const Points& vertices) const
    {
        const auto to_gradients = gradient_operator(tube.rest.volume_vertices, tube.prisms);
        const auto gradients = deformation_gradients(to_gradients, vertices);
        const Eigen::VectorXd volumes = prism_volumes(tube.rest.volume_vertices, tube.prisms);
        double sum = 0;
        for (Eigen::Index p = 0; p < gradients.rows(); ++p) {
            const Eigen::Matrix3d f =
                Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(gradients.row(p).data());
            Eigen::Vector3d stretches = f.jacobiSvd().singularValues();
            if (f.determinant() < 0) stretches[2] *= -1;
            sum += volumes[p] * (stretches.array() - 1).square().sum();
        }
        return sum;
    }
    Points after(const PosedBody& posed, int iterations) const
    {
        return projective_skinning(posed, rest, poisson, {iterations, 0});
    }
};

}  // namespace

TEST_CASE_METHOD(Scene, "Every iteration of Projective Skinning lowers its energy, from Gradient Skinning on")
{
    const PosedBody posed = poser.pose(tube.rest, test::tube_pose(1.4));
    REQUIRE(after(posed, 0) == gradient_skinning(posed, poisson));
    double before = energy(after(posed, 0));
    const double first = before;
    for (int iterations = 1; iterations <= 30; ++iterations) {
        const double now = energy(after(posed, iterations));
        REQUIRE(now < before);
        before = now;
    }
    CHECK(before < 0.9 * first);
    // Where an iteration gains too little no other follows.
    const Points stopped = projective_skinning(posed, rest, poisson, {100000, 0.01});
    CHECK(energy(stopped) < first);
    CHECK(energy(stopped) > before);
    CHECK((stopped.topRows(tube.num_wrap_vertices()) - posed.bone_wrap()).norm() == 0);
}

TEST_CASE_METHOD(Scene, "Projective Skinning ends where no vertex wants to move")
{
    const PosedBody posed = poser.pose(tube.rest, test::tube_pose(1.0));
    const auto steepness = [&](const Points& vertices) {
        double sum = 0;
        for (int v = tube.num_wrap_vertices(); v < tube.num_volume_vertices(); v += 5) {
            for (int c = 0; c < 3; ++c) {
                Points high = vertices, low = vertices;
                high(v, c) += 1e-6;
                low(v, c) -= 1e-6;
                sum += std::pow((energy(high) - energy(low)) / 2e-6, 2);
            }
        }
        return std::sqrt(sum);
    };
    CHECK(steepness(after(posed, 1000)) < 1e-3 * steepness(after(posed, 0)));
}

TEST_CASE_METHOD(Scene, "Projective Skinning leaves the rest pose as it is and moves rigidly with the root")
{
    Pose pose = Pose::rest(tube.skeleton.num_joints());
    CHECK((after(poser.pose(tube.rest, pose), 30) - tube.rest.volume_vertices).cwiseAbs().maxCoeff() < 1e-9);
    pose.parent_from_joint[0] = Eigen::AngleAxisd(2.5, Eigen::Vector3d(1, -1, 2).normalized()).toRotationMatrix();
    pose.root_translation << 0.2, 0.7, -0.4;
    const PosedBody posed = poser.pose(tube.rest, pose);
    Points expected = tube.rest.volume_vertices;
    for (Eigen::Index i = 0; i < expected.rows(); ++i)
        expected.row(i) = (posed.world_from_rest()[0] * Eigen::Vector3d(expected.row(i).transpose())).transpose();
    CHECK((after(posed, 30) - expected).cwiseAbs().maxCoeff() < 1e-6);
}

TEST_CASE_METHOD(Scene, "Projective Skinning as a method takes its options and the rest shape of each body")
{
    MethodTable table;
    register_projective_skinning(table);
    const auto deformer = table.find("projective-skinning").make(poser);
    Body large = tube.rest;
    for (Points* points : {&large.volume_vertices, &large.joint_positions}) *points *= 1.2;
    const RestOperators large_rest(tube.prisms, large.volume_vertices);
    const PoissonReconstruction large_poisson(large_rest, tube.num_wrap_vertices());
    for (int turn = 0; turn < 2; ++turn) {
        const PosedBody small = poser.pose(tube.rest, test::tube_pose(0.9)),
                        other = poser.pose(large, test::tube_pose(0.9));
        CHECK(deformer->deform(small) == projective_skinning(small, rest, poisson));
        CHECK(deformer->deform(other) == projective_skinning(other, large_rest, large_poisson));
    }
}
