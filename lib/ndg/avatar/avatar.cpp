// SPDX-License-Identifier: Apache-2.0
#include "ndg/avatar/avatar.h"

#include "ndg/avatar/pose_directions.h"
#include "ndg/core/error.h"
#include "ndg/core/parallel_for.h"

#include <Eigen/LU>
#include <Eigen/SVD>

#include <algorithm>

namespace ndg {

namespace {

constexpr int vertices_a_block = 512;

template <typename F>
void for_vertices(Eigen::Index count, const F& f)
{
    parallel_for(int((count + vertices_a_block - 1) / vertices_a_block), [&](int block) {
        const Eigen::Index begin = Eigen::Index(block) * vertices_a_block;
        for (Eigen::Index v = begin; v < std::min(begin + vertices_a_block, count); ++v) f(v);
    });
}

}  // namespace

Eigen::Matrix3d stretched_at_least(const Eigen::Matrix3d& linear, double least)
{
    // Means of rotations stretch nothing, so the determinant is at most the smallest stretch.
    if (linear.determinant() >= least) return linear;
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(linear, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d u = svd.matrixU();
    Eigen::Vector3d stretches = svd.singularValues();
    // The least stretch takes the sign: what is mirrored counts as less than nothing, and the rest is a rotation.
    if ((u * svd.matrixV().transpose()).determinant() < 0) {
        u.col(2) *= -1;
        stretches[2] *= -1;
    }
    return u * stretches.cwiseMax(least).asDiagonal() * svd.matrixV().transpose();
}

std::vector<Eigen::Isometry3d> AvatarPoser::world_from_rest(const Pose& pose) const
{
    return forward_kinematics(avatar_.skeleton, avatar_.joint_positions, pose);
}

std::vector<AffineMap> AvatarPoser::world_from_unposed(const Pose& pose) const
{
    const auto motions = world_from_rest(pose);
    const bool corrected = !avatar_.pose_joints.empty();
    Points offsets;
    if (corrected) offsets = pose_offsets(pose_features(pose, avatar_.pose_joints), avatar_.pose_directions);
    std::vector<AffineMap> maps(avatar_.rest.rows());
    for_vertices(avatar_.rest.rows(), [&](Eigen::Index v) {
        AffineMap map = blended_motion(avatar_.weights, motions, int(v));
        const Eigen::Vector3d rest = avatar_.rest.row(v);
        Eigen::Vector3d corrected_rest = rest;
        if (corrected) corrected_rest += offsets.row(v).transpose();
        const Eigen::Vector3d skinned = map * corrected_rest.homogeneous();
        map.leftCols<3>() = stretched_at_least(map.leftCols<3>(), least_map_stretch);
        map.col(3) = skinned - map.leftCols<3>() * rest;
        maps[v] = map;
    });
    return maps;
}

Points AvatarPoser::display_skin(const Pose& pose, const Eigen::Ref<const Points>& volume_positions) const
{
    require(volume_positions.rows() == avatar_.rest.rows(), "{} volume positions were given, the avatar has {}",
            volume_positions.rows(), avatar_.rest.rows());
    const auto motions = world_from_rest(pose);
    Points rest = avatar_.skin_vertices;
    if (!avatar_.pose_joints.empty())
        rest += pose_offsets(pose_features(pose, avatar_.pose_joints), avatar_.skin_pose_directions);
    Points skin(rest.rows(), 3);
    for_vertices(rest.rows(), [&](Eigen::Index v) {
        const int volume_vertex = avatar_.volume_vertex_of_skin[v];
        if (volume_vertex >= 0) {
            skin.row(v) = volume_positions.row(volume_vertex);
        } else {
            const Eigen::Vector3d skinned =
                blended_motion(avatar_.skin_weights, motions, int(v)) * rest.row(v).transpose().homogeneous();
            skin.row(v) = skinned.transpose();
        }
    });
    return skin;
}

Points to_world(const std::vector<AffineMap>& world_from_unposed, const Eigen::Ref<const Points>& unposed)
{
    require(Eigen::Index(world_from_unposed.size()) == unposed.rows(), "{} maps were given for {} vertices",
            world_from_unposed.size(), unposed.rows());
    Points world(unposed.rows(), 3);
    for_vertices(unposed.rows(), [&](Eigen::Index v) {
        const Eigen::Vector3d x = world_from_unposed[v] * unposed.row(v).transpose().homogeneous();
        world.row(v) = x.transpose();
    });
    return world;
}

Points to_unposed(const std::vector<AffineMap>& world_from_unposed, const Eigen::Ref<const Points>& world)
{
    require(Eigen::Index(world_from_unposed.size()) == world.rows(), "{} maps were given for {} vertices",
            world_from_unposed.size(), world.rows());
    Points unposed(world.rows(), 3);
    for_vertices(world.rows(), [&](Eigen::Index v) {
        const AffineMap& map = world_from_unposed[v];
        const Eigen::Vector3d u = map.leftCols<3>().inverse() * (world.row(v).transpose() - map.col(3));
        unposed.row(v) = u.transpose();
    });
    return unposed;
}

}  // namespace ndg
