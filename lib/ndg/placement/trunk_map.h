// SPDX-License-Identifier: Apache-2.0
// The trunk of one skeleton brought into another skin.
#pragma once

#include "ndg/placement/trunk_bones.h"

namespace ndg {

/// The skin a trunk is brought into, and what its fat is known by.
struct TrunkTarget {
    Points vertices;
    Triangles triangles;
    std::vector<char> on_trunk;  ///< per vertex: it belongs to trunk or neck, not to the arms
    Points joints;               ///< J x 3 of the standard skeleton; heights are taken from hips, clavicles and head
    double stature = 0;          ///< m
    double bmi = 0;              ///< kg/m^2
    double sex = 0.5;            ///< 0 female, 1 male
};

/// The vertices whose `weights` (N x J, standard skeleton) are mostly those of pelvis, spine, neck and clavicles.
std::vector<char> on_trunk(const Eigen::Ref<const RowMatrix>& weights);

/// x -> (scale_x(y) x, height(y), scale_z(y) z + offset_z(y)), with coefficients smooth in the height y of the source:
///   height  hips, clavicles and head come to the heights of the target's joints; the crests lie as far above the hips
///           as in people of that stature
///   back    the spinous processes C7 to L5 come to lie as deep under the midline of the back as in people of the
///           target's body mass index (spinous_depth), less what keeps the curves of the spine like the source's:
///           6 mm at most
///   front   the breastbone comes to lie under the skin by sternum_depth, and the sides of the rib cage by
///           rib_side_depth, as far as depth and breadth of the cage stay near those of people of that stature, sex and
///           body mass index; where the skin asks for more, the fat is thicker
///   pelvis  keeps its form; its breadth is between what stature and sex say and what the skin says
class TrunkMap {
public:
    /// `source_joints`: J x 3 of the skeleton `bones` belongs to. Throws Error where the skin has no trunk at a height.
    TrunkMap(const TrunkBones& bones, const Eigen::Ref<const Points>& source_joints, const TrunkTarget& target);

    Eigen::Vector3d operator()(const Eigen::Vector3d& source) const;

private:
    void fit_heights(const TrunkBones& bones, const Eigen::Ref<const Points>& source_joints, const TrunkTarget& target);
    void fit_breadths(const TrunkBones& bones, const TrunkTarget& target);
    void fit_depths(const TrunkBones& bones, const Eigen::Ref<const Points>& source_joints, const TrunkTarget& target);
    double height(double source_height) const;

    std::vector<double> height_knots_, height_values_;         ///< source height -> target height
    std::vector<double> section_heights_, scale_x_, scale_z_;  ///< by source height
    std::vector<double> offset_heights_, offset_z_;            ///< by source height
    double stature_scale_ = 1.0;
};

}  // namespace ndg
