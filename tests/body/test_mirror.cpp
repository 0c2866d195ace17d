// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/mirror.h"

#include "ndg/core/error.h"
#include "support/support.h"

#include <catch2/catch.hpp>

using namespace ndg;
using namespace ndg::test;

TEST_CASE("a symmetric template finds its mirror image")
{
    const Template tube = symmetric_tube_template();
    const TemplateMirror mirror = find_mirror(tube);
    CHECK(mirror.skin_residual < 1e-12);
    CHECK(mirror.wrap_residual < 1e-12);
    CHECK(mirror.weight_residual < 1e-12);
    const Skeleton& skeleton = tube.skeleton;
    CHECK(mirror.joints[skeleton.joint("left_forearm")] == skeleton.joint("right_forearm"));
    CHECK(mirror.joints[skeleton.joint("spine_2")] == skeleton.joint("spine_2"));
    const Points& rest = tube.rest.volume_vertices;
    for (Eigen::Index v = 0; v < rest.rows(); ++v) {
        const int opposite = mirror.vertices[v];
        CHECK(mirror.vertices[opposite] == v);
        CHECK((rest.row(opposite) - rest.row(v).cwiseProduct(Eigen::RowVector3d(-1, 1, 1))).norm() < 1e-12);
    }
    // The prism opposite has the vertices opposite, in the other order of corners.
    for (int p = 0; p < tube.num_prisms(); ++p) {
        std::vector<int> expected, found;
        for (int k = 0; k < 6; ++k) {
            expected.push_back(mirror.vertices[tube.prisms(p, k)]);
            found.push_back(tube.prisms(mirror.prisms[p], k));
        }
        CHECK_THAT(found, Catch::UnorderedEquals(expected));
    }
}

TEST_CASE("a posed body seen in the mirror is the mirrored body in the mirrored pose")
{
    const Template tube = symmetric_tube_template();
    const TemplateMirror mirror = find_mirror(tube);
    Pose pose = Pose::rest(tube.skeleton.num_joints());
    pose.root_translation << 0.2, 0.1, -0.3;
    int turn = 0;
    for (const char* joint : {"pelvis", "spine_2", "left_forearm", "right_upper_arm"}) {
        const Eigen::Vector3d axis = Eigen::Vector3d(1 + turn, 2 - turn, 0.5).normalized();
        pose.parent_from_joint[tube.skeleton.joint(joint)] =
            Eigen::AngleAxisd(0.4 + 0.3 * turn++, axis).toRotationMatrix();
    }
    const SkinningWeights weights = tube.volume_weights();
    Points body = tube.rest.volume_vertices;
    for (Eigen::Index v = 0; v < body.rows(); ++v) body(v, 0) *= 1.0 + 0.2 * std::sin(7.0 * v);  // not symmetric
    const auto posed = [&](const Points& rest, const Pose& in) {
        return linear_blend_skinning(rest, weights, forward_kinematics(tube.skeleton, tube.rest.joint_positions, in));
    };
    const Points image = mirror.mirrored(posed(body, pose));
    CHECK((image - posed(mirror.mirrored(body), mirror.mirrored(pose))).norm() < 1e-12);
    CHECK((image - posed(mirror.mirrored(body), pose)).norm() > 1e-2);
    CHECK((mirror.mirrored(image) - posed(body, pose)).norm() < 1e-12);
}

TEST_CASE("a template that is not symmetric is refused")
{
    // The tube's diagonals all turn one way.
    CHECK_THROWS_WITH(find_mirror(tube_template(5, 8)), Catch::Contains("no mirror image"));
    Template tube = symmetric_tube_template();
    tube.rest.volume_vertices(5, 0) += 0.05;  // of the bone wrap
    CHECK(find_mirror(tube).wrap_residual == Approx(0.05));
    tube.rest.volume_vertices(tube.num_volume_vertices() - 5, 0) += 0.05;
    CHECK_THROWS_WITH(find_mirror(tube), Catch::Contains("50.0 mm off"));
    tube = symmetric_tube_template();
    tube.skin_weights.joints(0, 0) = tube.skeleton.joint("head");
    CHECK_THROWS_WITH(find_mirror(tube), Catch::Contains("weights differ"));
    tube = symmetric_tube_template();
    tube.skeleton.joint_names[tube.skeleton.joint("left_eye")] = "left_ear";
    CHECK_THROWS_WITH(find_mirror(tube), Catch::Contains("no right_ear"));
}
