// SPDX-License-Identifier: Apache-2.0
// Tibia and kneecap of one side on the femur's condyles.
#pragma once

#include "ndg/core/types.h"
#include "ndg/geometry/distance_grid.h"

namespace ndg {

/// Both bones keep the gap to the femur that they have at rest: along the path that the pose (tibia) or the model
/// (kneecap) gives, they are shifted until the least distance of their vertices to the femur is that of rest.
class KneeMotion {
public:
    /// `femur`: closed surface. `hip`, `knee`: joints of the skeleton.
    KneeMotion(const Eigen::Vector3d& hip, const Eigen::Vector3d& knee, const Eigen::Ref<const Points>& femur_vertices,
               const Eigen::Ref<const Triangles>& femur_triangles, const Eigen::Ref<const Points>& tibia,
               const Eigen::Ref<const Points>& patella);

    struct Bones {
        Eigen::Isometry3d shank, patella;
    };
    /// `thigh`, `shin`: world_from_rest of these joints.
    Bones bones(const Eigen::Isometry3d& thigh, const Eigen::Isometry3d& shin) const;

    /// Radians, from the rest pose; positive where the shank goes back.
    double flexion(const Eigen::Isometry3d& thigh, const Eigen::Isometry3d& shin) const;

private:
    /// Vertices of a bone that come near the femur, and the least distance at rest.
    struct Facing {
        Points vertices;
        double rest_gap = 0.0;
    };
    Facing facing(const Points& vertices) const;
    double gap(const Points& vertices, const Eigen::Isometry3d& femur_from_rest) const;
    Eigen::VectorXd distances(const Points& vertices, const Eigen::Isometry3d& femur_from_rest) const;
    /// How far the bone must be shifted along `away` (in the femur's frame) to be as far from it as at rest.
    double shift(const Facing& bone, Eigen::Isometry3d femur_from_rest, const Eigen::Vector3d& away) const;

    Eigen::Vector3d knee_, up_, lateral_, forward_, patella_centre_;
    double scale_ = 1.0;
    ScalarGrid femur_distance_;  ///< around the knee
    Facing tibia_, patella_;
};

}  // namespace ndg
