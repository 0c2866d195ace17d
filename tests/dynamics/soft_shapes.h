// SPDX-License-Identifier: Apache-2.0
// Soft bodies for the tests of dynamics.
#pragma once

#include "ndg/dynamics/driven_body.h"
#include "support/support.h"

#include <array>

namespace ndg::test {

/// A block of cubes, six tetrahedra each, on the plane z = 0, whose vertices are held; the normal is +z, the skin the
/// upper side.
inline SoftBody soft_block(const std::array<int, 3>& cells, const Eigen::Vector3d& size, double young_normal,
                           double young_tangent)
{
    constexpr int corners[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};
    const int nx = cells[0] + 1, ny = cells[1] + 1, nz = cells[2] + 1;
    const auto vertex = [&](int i, int j, int k) { return (k * ny + j) * nx + i; };
    SoftBody body;
    body.name = "block";
    body.rest.resize(nx * ny * nz, 3);
    for (int k = 0; k < nz; ++k)
        for (int j = 0; j < ny; ++j)
            for (int i = 0; i < nx; ++i)
                body.rest.row(vertex(i, j, k)) << size[0] * i / cells[0], size[1] * j / cells[1],
                    size[2] * k / cells[2];
    body.num_held = nx * ny;
    body.tetrahedra.resize(6 * cells[0] * cells[1] * cells[2], 4);
    Eigen::Index row = 0;
    for (int k = 0; k < cells[2]; ++k)
        for (int j = 0; j < cells[1]; ++j)
            for (int i = 0; i < cells[0]; ++i)
                for (const auto& tetrahedron : corners) {
                    for (int a = 0; a < 4; ++a) {
                        const int c = tetrahedron[a];
                        body.tetrahedra(row, a) = vertex(i + c % 2, j + c / 2 % 2, k + c / 4);
                    }
                    ++row;
                }
    body.skin_triangles.resize(2 * cells[0] * cells[1], 3);
    row = 0;
    for (int j = 0; j < cells[1]; ++j)
        for (int i = 0; i < cells[0]; ++i) {
            const int top = cells[2];
            body.skin_triangles.row(row++) << vertex(i, j, top), vertex(i + 1, j, top), vertex(i + 1, j + 1, top);
            body.skin_triangles.row(row++) << vertex(i, j, top), vertex(i + 1, j + 1, top), vertex(i, j + 1, top);
        }
    body.normals = Points::Zero(body.rest.rows(), 3);
    body.normals.col(2).setOnes();
    body.young_normal_pascal.setConstant(body.rest.rows(), young_normal);
    body.young_tangent_pascal.setConstant(body.rest.rows(), young_tangent);
    return body;
}

/// The flesh of a tube template (support.h) as tetrahedra, three a prism, held at the bone wrap.
inline SoftBody soft_tube(const Template& tube, double young_normal, double young_tangent)
{
    const int num_wrap = tube.num_wrap_vertices();
    SoftBody body;
    body.name = "tube";
    body.rest = tube.rest.volume_vertices;
    body.num_held = num_wrap;
    body.tetrahedra.resize(3 * tube.num_prisms(), 4);
    for (Eigen::Index p = 0; p < tube.prisms.rows(); ++p) {
        std::array<int, 3> order{0, 1, 2};  // by wrap vertex, so that neighbours part their common side alike
        std::sort(order.begin(), order.end(), [&](int a, int b) { return tube.prisms(p, a) < tube.prisms(p, b); });
        const auto outer = [&](std::size_t k) { return tube.prisms(p, order[k]); };
        const auto inner = [&](std::size_t k) { return tube.prisms(p, order[k] + 3); };
        body.tetrahedra.row(3 * p) << outer(0), outer(1), outer(2), inner(2);
        body.tetrahedra.row(3 * p + 1) << outer(0), outer(1), inner(1), inner(2);
        body.tetrahedra.row(3 * p + 2) << outer(0), inner(0), inner(1), inner(2);
    }
    const Eigen::VectorXd volumes = tetrahedron_volumes(body.rest, body.tetrahedra);
    for (Eigen::Index t = 0; t < volumes.size(); ++t) {
        if (volumes[t] < 0) std::swap(body.tetrahedra(t, 0), body.tetrahedra(t, 1));
    }
    body.skin_triangles = tube.wrap_triangles.array() + 2 * num_wrap;
    body.normals = body.rest;  // the tube stands about the y axis
    body.normals.col(1).setZero();
    body.young_normal_pascal.setConstant(body.rest.rows(), young_normal);
    body.young_tangent_pascal.setConstant(body.rest.rows(), young_tangent);
    return body;
}

/// Nothing moves it.
inline SoftBodyPoser still_poser(int num_vertices)
{
    return {standard_skeleton(), Points::Zero(num_standard_joints, 3),
            [num_vertices](const Pose&) { return std::vector<AffineMap>(num_vertices, AffineMap::Identity()); }};
}

/// By linear blend skinning, with pose blend shapes of a kind: vertices shift at rest with the rotation of one joint.
inline SoftBodyPoser tube_poser(const Template& tube)
{
    const SkinningWeights weights = tube.volume_weights();
    const Skeleton skeleton = tube.skeleton;
    const Points joints = tube.rest.joint_positions;
    const Points rest = tube.rest.volume_vertices;
    return {skeleton, joints, [=](const Pose& pose) {
                const std::vector<Eigen::Isometry3d> motions = forward_kinematics(skeleton, joints, pose);
                const Eigen::Matrix3d& bend =
                    pose.parent_from_joint[static_cast<std::size_t>(skeleton.joint("left_forearm"))];
                std::vector<AffineMap> maps(static_cast<std::size_t>(rest.rows()), AffineMap::Zero());
                for (Eigen::Index v = 0; v < rest.rows(); ++v) {
                    AffineMap& map = maps[static_cast<std::size_t>(v)];
                    for (int k = 0; k < max_influences; ++k) {
                        map += weights.weights(v, k) *
                               motions[static_cast<std::size_t>(weights.joints(v, k))].matrix().topRows<3>();
                    }
                    const Eigen::Vector3d shift =
                        0.01 * std::sin(20 * rest(v, 1)) * (bend - Eigen::Matrix3d::Identity()).col(0);
                    map.col(3) += map.leftCols<3>() * shift;
                }
                return maps;
            }};
}

}  // namespace ndg::test
