// SPDX-License-Identifier: Apache-2.0
// The tetrahedra of an avatar's soft tissue: what skinning needs carried inside, and how they follow a change of
// thickness.
#pragma once

#include "ndg/avatar/avatar.h"
#include "ndg/avatar/soft_region.h"
#include "ndg/geometry/tetrahedralize.h"

#include <vector>

namespace ndg {

/// Takes the tetrahedra of the layer's surface (layer_surface of the avatar's skin, directions and thickness) and
/// carries weights, pose directions and normals from the outer vertices inside by the cotangent Laplacian (equation 2).
/// Its values may overshoot a little: weights below 1e-5 are left out and rows scaled to sum one. Control points'
/// weights are given on the inner surface too, as on the skin above. Reads of the avatar what belongs to skin and
/// control points (`region_control_weights`: W x C); sets what belongs to the volume.
void fill_volume(Avatar& avatar, const SoftRegion& region, const TetrahedralMesh& mesh,
                 const Eigen::Ref<const RowMatrix>& region_control_weights);

/// The region of an avatar that has a volume; without rim_distances.
SoftRegion avatar_region(const Avatar& avatar);
/// Thickness of each vertex of the inner surface (W) from values at the control points (C, m), held to its bounds.
std::vector<double> thickness_field(const Avatar& avatar, const std::vector<double>& control_values);

/// Moves the inner surface to another thickness (W) with the same tetrahedra: vertices inside follow by the cotangent
/// Laplacian with the whole boundary given. Weights, directions and normals stay with their vertices. Returns false,
/// and leaves the avatar as it is, where a tetrahedron would turn over or become a needle (radius ratio below 0.001).
/// Throws InputError for a thickness outside its bounds.
bool move_inner_surface(Avatar& avatar, const std::vector<double>& thickness);

/// How good tetrahedra are.
struct TetrahedraQuality {
    double least_dihedral = 0, greatest_dihedral = 0;      ///< radians
    double least_radius_ratio = 0, mean_radius_ratio = 0;  ///< 3 x inscribed over circumscribed radius: 1 is regular
    double least_volume = 0, total_volume = 0;             ///< m^3
};
TetrahedraQuality tetrahedra_quality(const Eigen::Ref<const Points>& vertices,
                                     const Eigen::Ref<const Tetrahedra>& tetrahedra);

}  // namespace ndg
