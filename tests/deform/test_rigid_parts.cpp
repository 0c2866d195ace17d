// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/anatomy.h"
#include "ndg/deform/rigid_parts.h"
#include "support/support.h"

#include <catch2/catch.hpp>

using namespace ndg;

TEST_CASE("Bones of rigid parts move with the joint that carries most of them, muscles bend by themselves")
{
    Template tube = test::tube_template();
    const AnatomyPart& bone = tube.anatomy_parts[0];
    const AnatomyPart& muscle = tube.anatomy_parts[1];
    const int upper_arm = tube.skeleton.joint("left_upper_arm"), forearm = tube.skeleton.joint("left_forearm");
    // Two thirds of the bone are the forearm's, the first vertices the upper arm's.
    const int third = bone.vertex_begin + (bone.vertex_end - bone.vertex_begin) / 3;
    for (int v = bone.vertex_begin; v < bone.vertex_end; ++v) {
        tube.anatomy_weights.weights.row(v).setZero();
        tube.anatomy_weights.joints(v, 0) = v < third ? upper_arm : forearm;
        tube.anatomy_weights.weights(v, 0) = 1;
    }
    const Points at_rest = anatomy_at_rest(tube, tube.rest);
    // Whatever moves the bone wrap.
    for (const BoneWrap wrap : {BoneWrap::rigid, BoneWrap::lbs}) {
        const BodyPoser poser(tube, {wrap});
        RigidParts parts(tube);
        const PosedBody posed = poser.pose(tube.rest, test::tube_pose(1.1));
        const Points volume = parts.deform(posed);
        CHECK(volume == posed.skinned_volume());
        const Points anatomy = parts.anatomy(posed, at_rest, volume);
        const Points skinned = linear_blend_skinning(at_rest, tube.anatomy_weights, posed.world_from_rest());
        for (int v = bone.vertex_begin; v < bone.vertex_end; ++v) {
            const Eigen::Vector3d expected = posed.world_from_rest()[forearm] * at_rest.row(v).transpose();
            CHECK((anatomy.row(v).transpose() - expected).norm() < 1e-12);
        }
        for (int v = muscle.vertex_begin; v < muscle.vertex_end; ++v)
            CHECK((anatomy.row(v) - skinned.row(v)).norm() < 1e-12);
        CHECK((anatomy - posed.anatomy(at_rest, volume)).norm() > 1e-2);
        const PosedBody rest = poser.pose(tube.rest, Pose::rest(tube.skeleton.num_joints()));
        CHECK((parts.anatomy(rest, at_rest, parts.deform(rest)) - at_rest).norm() < 1e-12);
    }
}
