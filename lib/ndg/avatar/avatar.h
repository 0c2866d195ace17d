// SPDX-License-Identifier: Apache-2.0
// The soft-tissue avatar (Romero et al. 2020, 3.2 to 3.4): one person's skin, the layer of soft tissue below it as
// tetrahedra, and what poses both. Spaces: *unposed* is the space of the rest shape, in which elastic energy is
// measured; *world* is that of the posed body.
#pragma once

#include "ndg/avatar/joint_weights.h"
#include "ndg/body/skeleton.h"
#include "ndg/core/provenance.h"
#include "ndg/core/types.h"
#include "ndg/geometry/affine_map.h"

#include <string>
#include <vector>

namespace ndg {

/// M volume vertices in this order: inner surface (one below each skin vertex of the layer), outer vertices of the rims
/// (where the layer ends at head, hands and feet), outer vertices that move freely, vertices inside. W skin vertices
/// have the layer below them, N has the whole skin, K are the joints.
struct Avatar {
    std::string name;
    std::string licences;  ///< licence and credit lines of the file it was read from; those who write know their inputs

    Points rest;               ///< M x 3, m: the reference shape
    int num_held = 0;          ///< rows of `rest`, the first ones, that are held to the skinned shape
    Tetrahedra tetrahedra;     ///< D x 4, positive volume at rest
    Triangles skin_triangles;  ///< T_w x 3 volume vertices, outward: the skin that has the layer below it
    Points normals;            ///< M x 3, unit: the skin's outward normal carried inside, for anisotropy
    JointWeights weights;      ///< M x K

    Skeleton skeleton;
    Points joint_positions;        ///< K x 3, m
    std::vector<int> pose_joints;  ///< P joints whose rotations drive the pose directions
    /// 9 P x 3 M, m: row 9 p + 3 r + c is the offset at rest (x y z of each vertex) for the entry (r, c) of R - I of
    /// pose joint p.
    RowMatrixF pose_directions;

    Points skin_vertices;             ///< N x 3, m: the whole closed skin at rest, for display
    Triangles whole_skin_triangles;   ///< T x 3 skin vertices
    JointWeights skin_weights;        ///< N x K
    RowMatrixF skin_pose_directions;  ///< 9 P x 3 N, m, as `pose_directions`

    std::vector<int> volume_vertex_of_skin;  ///< N: volume vertex of each skin vertex, -1 in head, hands and feet
    std::vector<int> skin_of_inner;          ///< W: skin vertex above each vertex of the inner surface
    Points inward;                           ///< W x 3, unit: from that skin vertex to its inner vertex
    /// W each, m: distance of inner vertex and skin, and what it may be.
    std::vector<double> thickness, min_thickness, max_thickness;

    std::vector<int> control_vertices;  ///< C skin vertices
    std::vector<int> mirror_vertices;   ///< C: the skin vertex on the other side with the same value, -1: none
    /// M x C: values at the control points to values at the volume vertices; rows in [0, 1], summing to one; an inner
    /// vertex has those of the skin above it.
    RowMatrix control_weights;

    int num_vertices() const { return static_cast<int>(rest.rows()); }
    int num_joints() const { return skeleton.num_joints(); }
};

/// Format "ndg-avatar", version 1 (docs/formats.md).
void write_avatar(const std::string& path, const Avatar& avatar, const Provenance& provenance);
/// Throws InputError naming file, dataset and value for what does not fit together: weights that do not sum to one,
/// parents that are no tree, tetrahedra that are inverted, thickness outside its bounds.
Avatar read_avatar(const std::string& path);

/// Least stretch of the linear parts of an avatar's maps. Blended rotations shrink some direction where they oppose
/// each other, down to nothing; a map of less stretch than this has its singular values raised to it, continuously,
/// and its translation such that the rest shape still goes to the skinned one. So every map is invertible, keeps
/// orientation, and its inverse stretches nothing by more than 1 / least_map_stretch.
constexpr double least_map_stretch = 0.2;
/// A linear map with its singular values raised to `least`; the smallest counts as negative where it mirrors.
Eigen::Matrix3d stretched_at_least(const Eigen::Matrix3d& linear, double least);

/// Poses of one avatar, which must outlive it. Const methods may run in several threads at once.
class AvatarPoser {
public:
    explicit AvatarPoser(const Avatar& avatar) : avatar_(avatar) {}
    explicit AvatarPoser(Avatar&&) = delete;

    /// K motions of the joints. Throws Error for a pose of another number of joints.
    std::vector<Eigen::Isometry3d> world_from_rest(const Pose& pose) const;
    /// M maps: x = L_i (u_i + offset_i(pose)) + t_i, where L_i, t_i blend the joints' motions and offset_i sums the
    /// pose directions. Where u = rest, x is the skinned shape p of the paper; where nothing moves, the map is the
    /// identity.
    std::vector<AffineMap> world_from_unposed(const Pose& pose) const;
    /// N x 3: the whole skin, with that of the volume (M x 3 world positions) where there is one.
    Points display_skin(const Pose& pose, const Eigen::Ref<const Points>& volume_positions) const;

private:
    const Avatar& avatar_;
};

/// x = map u of every vertex, and back; M x 3.
Points to_world(const std::vector<AffineMap>& world_from_unposed, const Eigen::Ref<const Points>& unposed);
Points to_unposed(const std::vector<AffineMap>& world_from_unposed, const Eigen::Ref<const Points>& world);

}  // namespace ndg
