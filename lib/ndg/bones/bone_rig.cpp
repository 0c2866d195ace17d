// SPDX-License-Identifier: Apache-2.0
#include "ndg/bones/bone_rig.h"

#include "ndg/body/anatomy.h"
#include "ndg/core/error.h"

#include <algorithm>

namespace ndg {

BoneRig::BoneRig(const Template& body_template) : list(body_template)
{
    require_input(list.num_segments > 0, "rigid bones need a template that has bones");
    const Points& anatomy = body_template.anatomy_vertices;
    const Body& rest = body_template.rest;
    wrap_weights =
        bone_weights(list, body_template, anatomy, rest.volume_vertices.topRows(body_template.num_wrap_vertices()));
    interior_weights = bone_weights(list, body_template, anatomy, rest.interior_vertices);
}

std::shared_ptr<const BoneMotion> RiggedBodies::motion(const Body& body) const
{
    constexpr std::size_t most = 32;
    const auto is_kept = [&](const Kept& kept) {
        return kept.body == &body && kept.joint_positions == body.joint_positions;
    };
    const auto use = [&](std::vector<Kept>::iterator found) {
        std::rotate(kept_.begin(), found, found + 1);
        return kept_.front().motion;
    };
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        const auto found = std::find_if(kept_.begin(), kept_.end(), is_kept);
        if (found != kept_.end()) return use(found);
    }
    // Made outside the lock: other threads have other bodies.
    auto made =
        std::make_shared<const BoneMotion>(rig_.list, *template_, body, anatomy_at_rest(*template_, body));
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = std::find_if(kept_.begin(), kept_.end(), is_kept);
    if (found != kept_.end()) return use(found);
    if (kept_.size() == most) kept_.pop_back();
    kept_.insert(kept_.begin(), {&body, body.joint_positions, made});
    return made;
}

void move_bones(const BoneList& list, const Eigen::Ref<const Points>& anatomy_rest,
                const std::vector<Eigen::Isometry3d>& segments, Points& anatomy)
{
    for (const BoneList::Bone& bone : list.bones) {
        const Eigen::Isometry3d& motion = segments[bone.segment];
        const Eigen::Index begin = bone.vertex_begin, count = bone.vertex_end - bone.vertex_begin;
        anatomy.middleRows(begin, count).noalias() =
            anatomy_rest.middleRows(begin, count) * motion.linear().transpose();
        anatomy.middleRows(begin, count).rowwise() += motion.translation().transpose();
    }
}

}  // namespace ndg
