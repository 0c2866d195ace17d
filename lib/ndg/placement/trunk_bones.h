// SPDX-License-Identifier: Apache-2.0
// What the trunk of a skeleton is placed by.
#pragma once

#include "ndg/body_source/template_source.h"

#include <vector>

namespace ndg {

/// Half-width of the strip around the midline in which breastbone and back are looked for, m.
constexpr double midline_half_width = 0.015;

/// Landmarks of a skeleton's trunk in the space of its own skin; it stands upright and faces +z.
struct TrunkBones {
    /// C7 to L5 (levels of spinous_depth), 18 x 3: spinous_tip of each vertebra.
    Points spinous_tips;
    /// Front of manubrium and breastbone in the midline, by ascending height: (height, z).
    std::vector<double> sternum_heights, sternum_fronts;
    /// Half the breadth of the rib cage, by ascending height.
    std::vector<double> rib_heights, rib_half_breadths;
    double crest_height = 0, crest_half_breadth = 0;  ///< of the iliac crests, where they are farthest apart
    double pelvis_top = 0;                            ///< highest point of the hip bones

    /// z of the line of the spinous tips at a height.
    double spinous_z(double height) const;
    /// Height of the middle of the breastbone, where depth and breadth of the cage are compared with published ones.
    double mid_sternum_height() const;
    /// Breastbone to spinous process there, m.
    double cage_depth() const;
    /// Greatest breadth of the cage, m.
    double cage_breadth() const;
};

/// Tip of a vertebra's spinous process: the point behind the vertebra's body, in its midline, that is farthest from it.
Eigen::Vector3d spinous_tip(const Eigen::Ref<const Points>& vertebra);

/// Finds them by the bones' names ("Eighth thoracic vertebra", "Body of sternum" or "Sternum", "Left fourth rib", "Left
/// hip bone"). Throws Error naming a bone that is missing.
TrunkBones trunk_bones(const std::vector<AnatomyMesh>& parts);

}  // namespace ndg
