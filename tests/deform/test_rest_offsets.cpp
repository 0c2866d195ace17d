// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/deform/rest_offsets.h"
#include "ndg/geometry/rotation.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <Eigen/LU>
#include <Eigen/SVD>

using namespace ndg;

TEST_CASE("Offsets of a skinned body that was changed at rest are that change, and give it back")
{
    const Template tube = test::tube_template(7, 6);
    const BodyPoser poser(tube, test::bending);
    const RestOffsets at_rest(tube);
    REQUIRE(at_rest.num_vertices() == 2 * tube.num_wrap_vertices());
    Pose pose = test::tube_pose(1.3);
    pose.parent_from_joint[0] = about_x(2.2);
    pose.root_translation << 0.3, -0.2, 1;
    Points change(at_rest.num_vertices(), 3);
    Random random(6, "offsets");
    for (Eigen::Index i = 0; i < change.size(); ++i) change.data()[i] = 0.01 * random.normal();
    Body changed = tube.rest;
    changed.volume_vertices.bottomRows(change.rows()) += change;
    const Points deformed = poser.pose(changed, pose).skinned_volume();
    const PosedBody posed = poser.pose(tube.rest, pose);
    CHECK((at_rest.offsets(posed, deformed.cast<float>()) - change).cwiseAbs().maxCoeff() < 2e-6);
    CHECK((at_rest.vertices(posed, change) - deformed).cwiseAbs().maxCoeff() < 1e-12);
    CHECK((at_rest.vertices(posed, 0 * change) - posed.skinned_volume()).norm() == 0);
    CHECK_THROWS_AS(at_rest.vertices(posed, change.topRows(3)), Error);
    CHECK_THROWS_AS(at_rest.offsets(posed, change.cast<float>()), Error);
}

TEST_CASE("Collapsed blends are undone within bounds, others exactly")
{
    const auto turn = [](double angle) -> Eigen::Matrix3d {
        return rotation_of(angle * Eigen::Vector3d(0.3, 1, -0.2).normalized());
    };
    const Eigen::Matrix3d ordinary = 0.3 * turn(0.2) + 0.7 * turn(1.9);
    CHECK((bounded_inverse(ordinary) - ordinary.inverse()).norm() < 1e-12);
    // Half-way between opposed rotations two directions collapse; the third is undone all the same.
    const Eigen::Matrix3d collapsed = 0.5 * turn(0.0) + 0.5 * turn(EIGEN_PI);
    const Eigen::Matrix3d undone = bounded_inverse(collapsed);
    CHECK(undone.norm() == Approx(1.0).margin(1e-9));
    const Eigen::Vector3d axis = Eigen::Vector3d(0.3, 1, -0.2).normalized();
    CHECK((undone * collapsed * axis - axis).norm() < 1e-9);
    // Continuous through the bound, and never larger than one over it.
    for (const double angle : {2.0, 2.5, 2.7, 2.74, 2.75, 3.0, 3.1, 3.14159}) {
        const Eigen::Matrix3d blend = 0.5 * turn(0.0) + 0.5 * turn(angle);
        const Eigen::Matrix3d next = 0.5 * turn(0.0) + 0.5 * turn(angle + 1e-6);
        CHECK((bounded_inverse(blend) - bounded_inverse(next)).norm() < 1e-3);
        CHECK(bounded_inverse(blend).jacobiSvd().singularValues()[0] <= 1 / least_blend_stretch + 1e-9);
        if (std::cos(angle / 2) > least_blend_stretch)
            CHECK((bounded_inverse(blend) * blend - Eigen::Matrix3d::Identity()).norm() < 1e-9);
    }
    // A forearm turned by half a circle against the upper arm: offsets stay bounded.
    const Template tube = test::tube_template(7, 6);
    const BodyPoser poser(tube, test::bending);
    const PosedBody posed = poser.pose(tube.rest, test::tube_pose(EIGEN_PI));
    Points vertices = posed.skinned_volume();
    vertices.array() += 0.01;
    const Points offsets = RestOffsets(tube).offsets(posed, vertices.cast<float>());
    CHECK(offsets.cwiseAbs().maxCoeff() < 0.01 * std::sqrt(3.0) / least_blend_stretch + 1e-3);
}
