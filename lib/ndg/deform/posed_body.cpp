// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/posed_body.h"

#include "ndg/body/anatomy.h"
#include "ndg/bones/rigid_wrap.h"
#include "ndg/core/error.h"

#include <utility>

namespace ndg {

BodyPoser::BodyPoser(const Template& body_template, const PosingOptions& options)
    : template_(&body_template),
      options_(options),
      rigged_(options.bone_wrap == BoneWrap::rigid ? std::make_shared<const RiggedBodies>(body_template) : nullptr),
      bone_wrap_weights_(select_weights(body_template.skin_weights, body_template.wrap_to_skin)),
      volume_weights_(body_template.volume_weights()),
      prism_weights_(body_template.prism_weights())
{
}

PosedBody BodyPoser::pose(const Body& body, const Pose& pose, const SamplePair& pair) const
{
    const int num_joints = template_->skeleton.num_joints();
    require(int(pose.parent_from_joint.size()) == num_joints,
            "the pose has {} joint rotations, the skeleton of the template {}", pose.parent_from_joint.size(),
            num_joints);
    require(body.joint_positions.rows() == num_joints, "body {} has {} joints, the skeleton of the template {}",
            body.name, body.joint_positions.rows(), num_joints);
    return PosedBody(*this, body, pose, pair);
}

PosedBody::PosedBody(const BodyPoser& poser, const Body& body, const Pose& pose, const SamplePair& pair)
    : poser_(&poser),
      body_(&body),
      pose_(pose),
      pair_(pair),
      world_from_rest_(forward_kinematics(poser.template_->skeleton, body.joint_positions, pose)),
      prism_rotations_(blend_rotations(poser.prism_weights_, world_from_rest_))
{
}

const Points& PosedBody::bone_wrap() const
{
    if (bone_wrap_.rows() > 0) return bone_wrap_;
    const auto rest_wrap = body_->volume_vertices.topRows(poser_->template_->num_wrap_vertices());
    if (poser_->rigged_) {
        RigidWrap wrap =
            pose_rigid_wrap(poser_->rigged_->rig(), *poser_->rigged_->of(*body_), rest_wrap, world_from_rest_);
        bone_segments_ = std::move(wrap.segments);
        bone_wrap_ = std::move(wrap.vertices);
    } else {
        bone_wrap_ = linear_blend_skinning(rest_wrap, poser_->bone_wrap_weights_, world_from_rest_);
    }
    return bone_wrap_;
}

Points PosedBody::skinned_volume() const
{
    Points volume = linear_blend_skinning(body_->volume_vertices, poser_->volume_weights_, world_from_rest_);
    volume.topRows(bone_wrap().rows()) = bone_wrap();
    return volume;
}

Points PosedBody::bone_interior() const
{
    if (poser_->rigged_) {
        bone_wrap();  // with it come the segments
        return dual_quaternion_blending(body_->interior_vertices, poser_->rigged_->rig().interior_weights,
                                        bone_segments_);
    }
    return linear_blend_skinning(body_->interior_vertices, body_template().interior_weights, world_from_rest_);
}

Points PosedBody::skinned_skin() const
{
    return linear_blend_skinning(body_->skin_vertices, body_template().skin_weights, world_from_rest_);
}

Points PosedBody::display_skin(const Eigen::Ref<const Points>& deformed_volume) const
{
    const Template& shared = body_template();
    require(deformed_volume.rows() == shared.num_volume_vertices(), "{} deformed volume vertices, the template has {}",
            deformed_volume.rows(), shared.num_volume_vertices());
    Points skin = skinned_skin();
    const int num_wrap = shared.num_wrap_vertices();
    for (int i = 0; i < num_wrap; ++i) skin.row(shared.wrap_to_skin[i]) = deformed_volume.row(2 * num_wrap + i);
    return skin;
}

Points PosedBody::anatomy(const Eigen::Ref<const Points>& anatomy_rest,
                          const Eigen::Ref<const Points>& deformed_volume) const
{
    Points anatomy =
        deformed_anatomy(body_template(), anatomy_rest, deformed_volume, bone_interior(), world_from_rest_);
    if (poser_->rigged_) {
        poser_->rigged_->attachments().hold(anatomy_rest, bone_segments_, anatomy);
        move_bones(poser_->rigged_->rig().list, anatomy_rest, bone_segments_, anatomy);
    }
    return anatomy;
}

}  // namespace ndg
