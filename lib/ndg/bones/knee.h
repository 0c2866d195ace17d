// SPDX-License-Identifier: Apache-2.0
// Tibia and kneecap of one side on the femur's condyles.
#pragma once

#include "ndg/core/types.h"

#include <vector>

namespace ndg {

/// How far two surfaces are apart: the least signed distance of the moving one's vertices to the fixed one.
class TriangleTree;
double surface_gap(const TriangleTree& fixed, const Eigen::Ref<const Points>& moving, const Eigen::Isometry3d& motion);

/// Both bones keep the gap to the femur that they have at rest: along the path that the pose (tibia) or the model (kneecap)
/// gives, shifts are measured once a body on its own surfaces, every 10 degrees of flexion, and interpolated.
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
    Eigen::Isometry3d patella_in_femur(double flexion, double shift) const;
    Eigen::Isometry3d shin_in_femur(double flexion) const;

    Eigen::Vector3d knee_, up_, lateral_, forward_, patella_centre_;
    double scale_ = 1.0;
    std::vector<double> shank_shifts_, patella_shifts_;  ///< m, away from the femur, at each step of flexion
};

}  // namespace ndg
