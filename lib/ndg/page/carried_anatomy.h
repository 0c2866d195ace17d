// SPDX-License-Identifier: Apache-2.0
// How the vertices of bones and muscles follow what a page stores for each frame.
#pragma once

#include "ndg/deform/posed_body.h"

#include <vector>

namespace ndg {

/// Vertex i of the anatomy is, in every frame,
///   (1 - shares[i]) * (the template's embedding, of volume and bone interior) + shares[i] * M[motions[i]] *
///   rest.row(i)
/// with the rigid motions M of bones; where that does not hold, the vertex is stored frame by frame.
struct CarriedAnatomy {
    Points rest;                 ///< N_a x 3, anatomy_at_rest of the body
    std::vector<int> motions;    ///< N_a, the bone whose motion the vertex follows, or lies next to
    std::vector<double> shares;  ///< N_a, 0 to 1: 1 on rigid bones, between where a muscle is attached
    std::vector<int> stored;     ///< vertices that are stored, ascending
    /// For each motion the part of the anatomy whose vertices tell it; -1 for one that stands still (no bones).
    std::vector<int> motion_parts;
};

/// Looks at poses `frames` of the body with the flesh `volumes` (each N_v x 3) and the anatomy `anatomies` (each
/// N_a x 3) and finds for every vertex what carries it within `tolerance` metres in all of them.
CarriedAnatomy find_carriers(const std::vector<PosedBody>& frames, const std::vector<Points>& volumes,
                             const std::vector<Points>& anatomies, double tolerance);

/// The motions of a frame, by least squares from the posed anatomy (N_a x 3) (Umeyama 1991, without scale).
std::vector<Eigen::Isometry3d> rigid_motions(const CarriedAnatomy& carried, const Template& body_template,
                                             const Eigen::Ref<const Points>& anatomy);

/// The formula above for a frame, N_a x 3; rows of stored vertices are taken from `anatomy`.
Points carried_points(const CarriedAnatomy& carried, const Embedding& embedding,
                      const Eigen::Ref<const Points>& volume_vertices,
                      const Eigen::Ref<const Points>& interior_vertices, const std::vector<Eigen::Isometry3d>& motions,
                      const Eigen::Ref<const Points>& anatomy);

}  // namespace ndg
