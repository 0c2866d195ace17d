// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/skeleton.h"
#include "ndg/wraps/bone_interior.h"
#include "ndg/wraps/wrap_skin.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;

namespace {

/// A tube of skin along the left upper arm and forearm, radius 0.05 m.
WrapSkin tube_skin(int rings, int segments)
{
    WrapSkin skin;
    const Skeleton& skeleton = standard_skeleton();
    skin.joint_positions.resize(skeleton.num_joints(), 3);
    for (int j = 0; j < skeleton.num_joints(); ++j) skin.joint_positions.row(j) << 10.0 + j, 0.0, 0.0;
    const int upper = skeleton.joint("left_upper_arm"), fore = skeleton.joint("left_forearm");
    skin.joint_positions.row(upper) << 0.0, -0.1, 0.0;
    skin.joint_positions.row(fore) << 0.0, 0.5, 0.0;
    skin.joint_positions.row(skeleton.joint("left_forearm_twist")) << 0.0, 0.8, 0.0;
    skin.joint_positions.row(skeleton.joint("left_hand")) << 0.0, 1.1, 0.0;
    skin.vertices.resize(rings * segments, 3);
    skin.weights = RowMatrix::Zero(rings * segments, skeleton.num_joints());
    skin.triangles.resize(2 * (rings - 1) * segments, 3);
    int t = 0;
    for (int r = 0; r < rings; ++r)
        for (int k = 0; k < segments; ++k) {
            const double angle = 2.0 * M_PI * k / segments, y = static_cast<double>(r) / (rings - 1);
            const int v = r * segments + k, next = r * segments + (k + 1) % segments;
            skin.vertices.row(v) << 0.05 * std::cos(angle), y, 0.05 * std::sin(angle);
            skin.weights(v, y < 0.5 ? upper : fore) = 1.0;
            if (r + 1 == rings) continue;
            skin.triangles.row(t++) << v, v + segments, next;
            skin.triangles.row(t++) << next, v + segments, next + segments;
        }
    return skin;
}

}  // namespace

TEST_CASE("bone interior fills the wrap, its weights blend, and it follows the wrap", "[build]")
{
    const WrapSkin skin = tube_skin(9, 8);
    const BoneInterior interior = fill_bone_wrap(skin.vertices, skin.triangles, skin.weights);
    const int num_wrap = static_cast<int>(skin.vertices.rows());
    CHECK(interior.vertices.rows() >= 2);
    CHECK(interior.tetrahedra.maxCoeff() < num_wrap + interior.vertices.rows());
    CHECK((interior.weights.rowwise().sum().array() - 1.0).abs().maxCoeff() < 1e-9);
    CHECK(interior.weights.minCoeff() > -1e-9);

    const Points same = transfer_interior(skin.vertices, interior.vertices, interior.tetrahedra, skin.vertices);
    CHECK((same - interior.vertices).norm() < 1e-10);
    Points moved_wrap = skin.vertices;
    moved_wrap.rowwise() += Eigen::RowVector3d(0.1, -0.2, 0.3);
    const Points moved = transfer_interior(skin.vertices, interior.vertices, interior.tetrahedra, moved_wrap);
    CHECK(((moved - interior.vertices).rowwise() - Eigen::RowVector3d(0.1, -0.2, 0.3)).norm() < 1e-9);
}
