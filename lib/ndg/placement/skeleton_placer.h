// SPDX-License-Identifier: Apache-2.0
// Where the bones of a template lie in another skin of its tessellation.
#pragma once

#include "ndg/body/template.h"
#include "ndg/placement/trunk_map.h"

namespace ndg {

/// One rule for drawn people and fitted scans: the trunk by what the skin shows of it (TrunkMap), the limbs by their
/// joints.
class SkeletonPlacer {
public:
    /// Keeps a reference to `body_template`, which must outlive it. Throws Error when its anatomy has no spine, ribs,
    /// breastbone or hip bones by name.
    explicit SkeletonPlacer(const Template& body_template);

    /// Whether a template has the bones that are needed; test templates may have none.
    static bool has_trunk_bones(const Template& body_template);

    /// From the template body's trunk to that of `skin`. `sex`: 0 female, 1 male.
    TrunkMap trunk_map(const Skin& skin, double sex) const;
    /// Joints of `skin` with those of the trunk (pelvis, spine, neck, clavicles, hips) where its bones are, by its
    /// trunk_map; the others, and the heights of hips, clavicles and head, are those of `skin.joint_positions`. Placing
    /// them again changes nothing. J x 3.
    Points joints(const Skin& skin, const TrunkMap& map) const;

private:
    const Template* template_;
    std::vector<char> on_trunk_;
    std::vector<int> trunk_joints_;
    TrunkBones bones_;
};

}  // namespace ndg
