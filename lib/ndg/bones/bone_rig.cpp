// SPDX-License-Identifier: Apache-2.0
#include "ndg/bones/bone_rig.h"

#include "ndg/body/anatomy.h"
#include "ndg/core/error.h"

#include <algorithm>

namespace ndg {

namespace {

BoneWeights wrap_weights_of(const BoneList& list, const Template& body_template)
{
    require_input(list.num_segments > 0, "rigid bones need a template that has bones; --bone-wrap lbs does without");
    const int num_wrap = body_template.num_wrap_vertices();
    const auto wrap = body_template.rest.volume_vertices.topRows(num_wrap);
    return smoothed_weights(near_bones(list, body_template, body_template.anatomy_vertices, wrap).weights, wrap,
                            body_template.wrap_triangles);
}

}  // namespace

BoneRig::BoneRig(const Template& body_template)
    : list(body_template),
      wrap_weights(wrap_weights_of(list, body_template)),
      interior_weights(
          near_bones(list, body_template, body_template.anatomy_vertices, body_template.rest.interior_vertices)
              .weights),
      peaks(list, body_template, wrap_weights)
{
}

BodyRig::BodyRig(const BoneRig& rig, const Template& body_template, const Body& body)
    : BodyRig(rig, body_template, body, anatomy_at_rest(body_template, body))
{
}

BodyRig::BodyRig(const BoneRig& rig, const Template& body_template, const Body& body, const Points& anatomy_rest)
    : motion(rig.list, body_template, body, anatomy_rest),
      clearance(rig.peaks, anatomy_rest, body.volume_vertices.topRows(body_template.num_wrap_vertices()))
{
}

std::shared_ptr<const BodyRig> RiggedBodies::of(const Body& body) const
{
    constexpr std::size_t most = 32;
    const auto is_kept = [&](const Kept& kept) {
        return kept.body == &body && kept.joint_positions == body.joint_positions;
    };
    const auto use = [&](std::vector<Kept>::iterator found) {
        std::rotate(kept_.begin(), found, found + 1);
        return kept_.front().rig;
    };
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        const auto found = std::find_if(kept_.begin(), kept_.end(), is_kept);
        if (found != kept_.end()) return use(found);
    }
    // Made outside the lock: other threads have other bodies.
    auto made = std::make_shared<const BodyRig>(rig_, *template_, body);
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = std::find_if(kept_.begin(), kept_.end(), is_kept);
    if (found != kept_.end()) return use(found);
    if (kept_.size() == most) kept_.pop_back();
    kept_.insert(kept_.begin(), {&body, body.joint_positions, made});
    return made;
}

const Attachments& RiggedBodies::attachments() const
{
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!attachments_) attachments_ = std::make_unique<const Attachments>(rig_.list, *template_);
    return *attachments_;
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
