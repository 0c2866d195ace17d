// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/posed_body.h"

#include "ndg/core/error.h"

namespace ndg {

BodyPoser::BodyPoser(const Template& body_template)
    : template_(&body_template),
      bone_wrap_weights_(select_weights(body_template.skin_weights, body_template.wrap_to_skin)),
      volume_weights_(body_template.volume_weights()),
      prism_weights_(body_template.prism_weights())
{
}

std::vector<Eigen::Isometry3d> BodyPoser::world_from_rest(const Body& body, const Pose& pose) const
{
    const int num_joints = template_->skeleton.num_joints();
    require(static_cast<int>(pose.parent_from_joint.size()) == num_joints,
            "the pose has {} joint rotations, the skeleton of the template {}", pose.parent_from_joint.size(),
            num_joints);
    require(body.joint_positions.rows() == num_joints, "body {} has {} joints, the skeleton of the template {}",
            body.name, body.joint_positions.rows(), num_joints);
    return forward_kinematics(template_->skeleton, body.joint_positions, pose);
}

Points BodyPoser::bone_wrap(const Body& body, const std::vector<Eigen::Isometry3d>& world_from_rest) const
{
    return linear_blend_skinning(body.volume_vertices.topRows(template_->num_wrap_vertices()), bone_wrap_weights_,
                                 world_from_rest);
}

Points BodyPoser::volume(const Body& body, const std::vector<Eigen::Isometry3d>& world_from_rest) const
{
    return linear_blend_skinning(body.volume_vertices, volume_weights_, world_from_rest);
}

Points BodyPoser::interior(const Body& body, const std::vector<Eigen::Isometry3d>& world_from_rest) const
{
    return linear_blend_skinning(body.interior_vertices, template_->interior_weights, world_from_rest);
}

Points BodyPoser::skin(const Body& body, const std::vector<Eigen::Isometry3d>& world_from_rest) const
{
    return linear_blend_skinning(body.skin_vertices, template_->skin_weights, world_from_rest);
}

std::vector<Eigen::Matrix3d> BodyPoser::prism_rotations(const std::vector<Eigen::Isometry3d>& world_from_rest) const
{
    return blend_rotations(prism_weights_, world_from_rest);
}

Points BodyPoser::display_skin(const Body& body, const std::vector<Eigen::Isometry3d>& world_from_rest,
                               const Eigen::Ref<const Points>& deformed_volume) const
{
    require(deformed_volume.rows() == template_->num_volume_vertices(),
            "{} deformed volume vertices, the template has {}", deformed_volume.rows(),
            template_->num_volume_vertices());
    Points skinned = skin(body, world_from_rest);
    const int num_wrap = template_->num_wrap_vertices();
    for (int i = 0; i < num_wrap; ++i) {
        skinned.row(template_->wrap_to_skin[static_cast<std::size_t>(i)]) = deformed_volume.row(2 * num_wrap + i);
    }
    return skinned;
}

}  // namespace ndg
