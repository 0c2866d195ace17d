// SPDX-License-Identifier: Apache-2.0
// Rigid bones and what follows them: for a template, and for each of its bodies.
#pragma once

#include "ndg/bones/bone_wrap.h"

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace ndg {

/// What all bodies of a template share.
struct BoneRig {
    /// Throws InputError where the template has no bones.
    explicit BoneRig(const Template& body_template);

    BoneList list;
    BoneWeights wrap_weights;      ///< N_w
    BoneWeights interior_weights;  ///< N_i
};

/// Motions of one body's bones; kept per body because the paths of its knees are measured on it.
class RiggedBodies {
public:
    /// Keeps a reference to `body_template`.
    explicit RiggedBodies(const Template& body_template) : template_(&body_template), rig_(body_template) {}

    const BoneRig& rig() const { return rig_; }
    /// Made when first asked for; a few bodies are kept, told apart by address and joints. Any thread.
    std::shared_ptr<const BoneMotion> motion(const Body& body) const;

private:
    struct Kept {
        const Body* body;
        Points joint_positions;
        std::shared_ptr<const BoneMotion> motion;
    };
    const Template* template_;
    BoneRig rig_;
    mutable std::mutex mutex_;
    mutable std::vector<Kept> kept_;  ///< the one used last first
};

/// Overwrites the rows of all bones in `anatomy` (N_a x 3) by `anatomy_rest` moved with their segments.
void move_bones(const BoneList& list, const Eigen::Ref<const Points>& anatomy_rest,
                const std::vector<Eigen::Isometry3d>& segments, Points& anatomy);

}  // namespace ndg
