// SPDX-License-Identifier: Apache-2.0
// Which part of the skin is volumetric: everything but head, hands and toes (NDG 3.1).
#pragma once

#include "ndg/core/types.h"

#include <string>
#include <vector>

namespace ndg {

/// Regions of the skin. The volumetric region is `body`; the others stay surfaces moved by linear blend skinning.
/// body, head, left_hand, right_hand, left_toes, right_toes
extern const std::vector<std::string> skin_region_names;

/// Where a region is cut off the body: it lies on the side the normal points to. The neck's plane is square to the
/// neck, 40 % of the way from neck_1 to head; the wrist's square to the forearm, 6 % of its length above the hand
/// joint; the toes' is vertical through the toes joint.
struct CuttingPlane {
    int region = 0;  ///< index into skin_region_names
    Eigen::RowVector3d point, normal;
    std::vector<int> joints;      ///< chain that the cut crosses, with all joints below
    std::vector<int> far_joints;  ///< joints beyond the cut
};
std::vector<CuttingPlane> cutting_planes(const Eigen::Ref<const Points>& joint_positions);

/// The surface cut along those planes, every triangle with its region. `weights`: N x J dense; they say where head,
/// hands and toes are. Throws InputError naming the region when a region is missing or its plane crosses the skin in
/// more than one loop.
struct RegionCut {
    Points vertices;  ///< input vertices first
    Triangles triangles;
    std::vector<int> regions;  ///< T
};
RegionCut cut_regions(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                      const Eigen::Ref<const RowMatrix>& weights, const Eigen::Ref<const Points>& joint_positions);

/// Signed field on the vertices of a surface, negative in the volumetric region, positive in head, hands and toes: the
/// distance in metres to the cutting plane of the chain a vertex belongs to (by its weights), -1 far from any cut.
/// `weights`: N x J dense on the standard skeleton.
Eigen::VectorXd region_field(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const RowMatrix>& weights,
                             const Eigen::Ref<const Points>& joint_positions);

/// The surface with triangles split along the zero line of a vertex field, so that every triangle lies on one side.
struct CutSurface {
    Points vertices;  ///< input vertices first
    Triangles triangles;
    std::vector<int> triangle_labels;   ///< 1 where the field is negative, 0 where positive
    std::vector<int> triangle_parents;  ///< the input triangle each lies in
};
/// Vertices with |field| below `snap` (metres) move onto the line instead of making slivers beside it: their field
/// value is taken as zero, their position stays.
CutSurface cut_along_zero(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                          const Eigen::VectorXd& field, double snap);

}  // namespace ndg
