// SPDX-License-Identifier: Apache-2.0
// Rigid bones and what follows them: for a template, and for each of its bodies.
#pragma once

#include "ndg/bones/attachments.h"
#include "ndg/bones/clearance.h"

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace ndg {

/// What all bodies of a template share.
struct BoneRig {
    /// Throws InputError where the template has no bones.
    explicit BoneRig(const Template& body_template);
    BoneRig(const BoneRig&) = delete;
    BoneRig& operator=(const BoneRig&) = delete;

    BoneList list;
    BoneWeights wrap_weights;      ///< N_w
    BoneWeights interior_weights;  ///< N_i
    WrapPeaks peaks;
};

/// What depends on a body's own bones.
struct BodyRig {
    BodyRig(const BoneRig& rig, const Template& body_template, const Body& body);

    BoneMotion motion;
    BoneClearance clearance;

private:
    BodyRig(const BoneRig& rig, const Template& body_template, const Body& body, const Points& anatomy_rest);
};

/// The rigs of bodies of one template.
class RiggedBodies {
public:
    /// Keeps a reference to `body_template`.
    explicit RiggedBodies(const Template& body_template) : template_(&body_template), rig_(body_template) {}

    const BoneRig& rig() const { return rig_; }
    /// Made when first asked for; a few bodies are kept, told apart by address and joints. Any thread.
    std::shared_ptr<const BodyRig> of(const Body& body) const;
    /// Made when first asked for. Any thread.
    const Attachments& attachments() const;

private:
    struct Kept {
        const Body* body;
        Points joint_positions;
        std::shared_ptr<const BodyRig> rig;
    };
    const Template* template_;
    BoneRig rig_;
    mutable std::mutex mutex_;
    mutable std::unique_ptr<const Attachments> attachments_;
    mutable std::vector<Kept> kept_;  ///< the one used last first
};

/// Overwrites the rows of all bones in `anatomy` (N_a x 3) by `anatomy_rest` moved with their segments.
void move_bones(const BoneList& list, const Eigen::Ref<const Points>& anatomy_rest,
                const std::vector<Eigen::Isometry3d>& segments, Points& anatomy);

}  // namespace ndg
