// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/posed_body.h"

#include "ndg/body/anatomy.h"
#include "ndg/core/error.h"
#include "ndg/deform/gradient_skinning.h"
#include "support/support.h"

#include <catch2/catch.hpp>

using namespace ndg;

namespace {

double largest_distance(const Points& a, const Points& b)
{
    return (a - b).rowwise().norm().maxCoeff();
}

PoissonReconstruction make_poisson(const Template& tube)
{
    return PoissonReconstruction(RestOperators(tube.prisms, tube.rest.volume_vertices), tube.num_wrap_vertices());
}

}  // namespace

TEST_CASE("Gradient skinning and skinning at rest give the rest shape; under a root motion they move with it")
{
    const Template tube = test::tube_template(7, 6);
    const BodyPoser poser(tube, test::bending);
    const PoissonReconstruction poisson = make_poisson(tube);
    Pose pose = Pose::rest(tube.skeleton.num_joints());
    const PosedBody at_rest = poser.pose(tube.rest, pose);
    REQUIRE(largest_distance(gradient_skinning(at_rest, poisson), tube.rest.volume_vertices) < 1e-10);
    REQUIRE(largest_distance(at_rest.skinned_volume(), tube.rest.volume_vertices) < 1e-12);
    REQUIRE(largest_distance(at_rest.skinned_skin(), tube.rest.skin_vertices) < 1e-12);
    REQUIRE(largest_distance(at_rest.bone_interior(), tube.rest.interior_vertices) < 1e-12);

    pose.parent_from_joint[0] = Eigen::AngleAxisd(2, Eigen::Vector3d(1, 1, 3).normalized()).toRotationMatrix();
    pose.root_translation = Eigen::Vector3d(0.1, 0.2, 0.3);
    const PosedBody posed = poser.pose(tube.rest, pose);
    Points expected = tube.rest.volume_vertices;
    for (Eigen::Index i = 0; i < expected.rows(); ++i) {
        expected.row(i) = (posed.world_from_rest()[0] * Eigen::Vector3d(expected.row(i).transpose())).transpose();
    }
    REQUIRE(largest_distance(expected, tube.rest.volume_vertices) > 0.1);
    REQUIRE(largest_distance(gradient_skinning(posed, poisson), expected) < 1e-10);
    REQUIRE(largest_distance(posed.skinned_volume(), expected) < 1e-10);
}

TEST_CASE("The bone wrap of every method is the skinned one; the display skin takes the deformed volume")
{
    const Template tube = test::tube_template(7, 6);
    const BodyPoser poser(tube, test::bending);
    const PoissonReconstruction poisson = make_poisson(tube);
    const PosedBody posed = poser.pose(tube.rest, test::tube_pose(1));
    const Points volume = gradient_skinning(posed, poisson);
    const int fixed = tube.num_wrap_vertices();
    REQUIRE(largest_distance(volume.topRows(fixed), posed.bone_wrap()) == 0);
    REQUIRE(largest_distance(posed.skinned_volume().topRows(fixed), posed.bone_wrap()) < 1e-12);
    REQUIRE(largest_distance(volume, posed.skinned_volume()) > 1e-3);

    const Points skin = posed.display_skin(volume);
    const Points skinned = posed.skinned_skin();
    std::vector<char> in_volume(skin.rows(), 0);
    for (int i = 0; i < fixed; ++i) {
        const int vertex = tube.wrap_to_skin[i];
        in_volume[vertex] = 1;
        REQUIRE((skin.row(vertex) - volume.row(2 * fixed + i)).norm() == 0);
    }
    for (Eigen::Index v = 0; v < skin.rows(); ++v) {
        if (!in_volume[v]) REQUIRE((skin.row(v) - skinned.row(v)).norm() == 0);
    }
}

TEST_CASE("A pose or body of another skeleton is refused")
{
    const Template tube = test::tube_template(4, 5);
    const BodyPoser poser(tube, test::bending);
    Pose pose = test::tube_pose(0.5);
    REQUIRE(poser.pose(tube.rest, pose).pair().body_idx == -1);
    REQUIRE(poser.pose(tube.rest, pose, {2, 7}).pair() == SamplePair{2, 7});
    Body body = tube.rest;
    body.joint_positions.conservativeResize(5, 3);
    REQUIRE_THROWS_AS(poser.pose(body, pose), Error);
    pose.parent_from_joint.pop_back();
    REQUIRE_THROWS_AS(poser.pose(tube.rest, pose), Error);
}

TEST_CASE("Rigid bones stay rigid where linear blend skinning bends them, and the wrap follows them")
{
    const Template tube = test::tube_template();
    const BodyPoser lbs(tube, {BoneWrap::lbs}), rigid(tube);
    CHECK(rigid.options().bone_wrap == BoneWrap::rigid);
    const Points anatomy = anatomy_at_rest(tube, tube.rest);
    const int num_bone = tube.anatomy_parts.front().vertex_end;
    const auto lengths = [&](const Points& points) -> Eigen::VectorXd {
        return (points.topRows(num_bone).rowwise() - points.row(0)).rowwise().norm();
    };
    const auto change = [&](const PosedBody& posed) {
        return (lengths(posed.anatomy(anatomy, posed.skinned_volume())) - lengths(anatomy)).cwiseAbs().maxCoeff();
    };
    const Pose bent = test::tube_pose(1.2);
    CHECK(change(lbs.pose(tube.rest, bent)) > 0.05);
    const PosedBody posed = rigid.pose(tube.rest, bent);
    CHECK(change(posed) < 1e-12);

    const int num_wrap = tube.num_wrap_vertices();
    CHECK(largest_distance(posed.skinned_volume().topRows(num_wrap), posed.bone_wrap()) == 0);
    // One bone alone: wrap and interior move as one with it.
    const Points rest_wrap = tube.rest.volume_vertices.topRows(num_wrap), wrap = posed.bone_wrap();
    CHECK((wrap.row(5) - wrap.row(40)).norm() == Approx((rest_wrap.row(5) - rest_wrap.row(40)).norm()));
    CHECK((wrap.row(5) - posed.bone_interior().row(0)).norm() ==
          Approx((rest_wrap.row(5) - tube.rest.interior_vertices.row(0)).norm()));
    const PosedBody at_rest = rigid.pose(tube.rest, Pose::rest(tube.skeleton.num_joints()));
    CHECK(largest_distance(at_rest.bone_wrap(), rest_wrap) < 1e-12);
}
