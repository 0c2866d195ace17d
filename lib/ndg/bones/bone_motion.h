// SPDX-License-Identifier: Apache-2.0
// All bones of a body in a pose, each moved as a rigid body.
#pragma once

#include "ndg/body/template.h"
#include "ndg/bones/bone_names.h"

#include <memory>
#include <vector>

namespace ndg {

/// The bones of a template, and which of them always move together.
struct BoneList {
    explicit BoneList(const Template& body_template);

    struct Bone {
        BoneName name;
        BodySide side = BodySide::middle;
        int vertex_begin = 0, vertex_end = 0, triangle_begin = 0, triangle_end = 0;  ///< of the anatomy
        int segment = 0;
    };
    std::vector<Bone> bones;  ///< the parts of layer bone, in their order
    int num_segments = 0;     ///< bones of one segment have one motion

    /// First bone of a kind, side and number; nullptr for none.
    const Bone* find(BoneKind kind, BodySide side, int number = -1) const;
};

/// Of one body. Vertebrae, ribs and sternum, shoulders, forearms and knees move as spine.h, thorax.h, limbs.h and
/// knee.h say; other bones with their joint; bones that no rule knows, or for which a neighbour that the rule needs is
/// missing, by the rigid motion that fits their linear blend skinning best (Kabsch 1976).
class BoneMotion {
public:
    /// Keeps a reference to `list`. `anatomy_rest`: anatomy_at_rest of the body, N_a x 3. Throws Error where the
    /// template has other anatomy.
    BoneMotion(const BoneList& list, const Template& body_template, const Body& body,
               const Eigen::Ref<const Points>& anatomy_rest);
    ~BoneMotion();
    BoneMotion(BoneMotion&&) noexcept;

    /// World_from_rest of every segment, at most micrometres from the identity for the joints of the rest pose.
    /// `joints`: forward_kinematics of the body.
    std::vector<Eigen::Isometry3d> segments(const std::vector<Eigen::Isometry3d>& joints) const;

private:
    struct Rules;
    std::unique_ptr<Rules> rules_;
};

}  // namespace ndg
