// SPDX-License-Identifier: Apache-2.0
#include "ndg/runtime/input_space.h"

#include "ndg/core/error.h"
#include "ndg/runtime/model_traits.h"

namespace ndg {
InputSpace::InputSpace(const Template& body_template, const ShapeSpace& shape_space, bool sees_shape)
    : shape_space_(shape_space),
      sees_shape_(sees_shape),
      code_scale_(shape_code_scale(shape_space)),
      joint_names_(body_template.skeleton.joint_names),
      visible_joints_(body_template.visible_joints())
{
    require_input(shape_space.mean.size() == 3 * body_template.num_volume_vertices(),
                  "the shape space has {} coordinates where the template's volume has {}", shape_space.mean.size(),
                  3 * body_template.num_volume_vertices());
}

int InputSpace::width() const
{
    return 9 * static_cast<int>(visible_joints_.size()) + (sees_shape_ ? shape_space_.dimension() : 0);
}

Eigen::RowVectorXf InputSpace::features(const PoseInput& input) const
{
    const int num_joints = static_cast<int>(visible_joints_.size());
    require_input(input.pose.parent_from_joint.size() == visible_joints_.size(),
                  "the pose has {} joints where the network expects {}", input.pose.parent_from_joint.size(),
                  num_joints);
    Eigen::RowVectorXf features = Eigen::RowVectorXf::Zero(width());
    for (int joint = 0; joint < num_joints; ++joint) {
        if (!visible_joints_[joint]) continue;
        const Eigen::Matrix3d& rotation = input.pose.parent_from_joint[joint];
        for (int row = 0; row < 3; ++row)
            for (int col = 0; col < 3; ++col)
                features[9 * joint + 3 * row + col] = static_cast<float>(rotation(row, col) - (row == col ? 1.0 : 0.0));
    }
    if (!sees_shape_) return features;
    require_input(input.shape_code.size() == shape_space_.dimension(),
                  "the shape code has {} numbers where the network's shape space has {}", input.shape_code.size(),
                  shape_space_.dimension());
    for (int k = 0; k < shape_space_.dimension(); ++k)
        features[9 * num_joints + k] = static_cast<float>(input.shape_code[k] / code_scale_);
    return features;
}

}  // namespace ndg
