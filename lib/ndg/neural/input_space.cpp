// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/input_space.h"

#include "ndg/core/error.h"

#include <algorithm>

namespace ndg {
namespace {

constexpr double visible_weight = 1e-3;

}  // namespace

std::vector<int> visible_joints(const Template& body_template)
{
    const Skeleton& skeleton = body_template.skeleton;
    const SkinningWeights weights = body_template.volume_weights();
    std::vector<int> visible(static_cast<std::size_t>(skeleton.num_joints()), 0);
    for (Eigen::Index i = 0; i < weights.size(); ++i)
        for (int k = 0; k < max_influences; ++k)
            if (weights.weights(i, k) >= visible_weight) visible[static_cast<std::size_t>(weights.joints(i, k))] = 1;
    // A joint turns its descendants too; parents come before children.
    for (int joint = skeleton.num_joints() - 1; joint > 0; --joint)
        if (visible[static_cast<std::size_t>(joint)])
            visible[static_cast<std::size_t>(skeleton.parents[static_cast<std::size_t>(joint)])] = 1;
    if (!visible.empty()) visible[0] = 0;
    return visible;
}

Eigen::RowVectorXf network_features(const PoseInput& input, const std::vector<int>& visible,
                                    const ShapeSpace& shape_space, bool shape)
{
    const auto num_joints = static_cast<Eigen::Index>(visible.size());
    require_input(input.pose.parent_from_joint.size() == visible.size(),
                  "the pose has {} joints where the network expects {}", input.pose.parent_from_joint.size(),
                  visible.size());
    const Eigen::Index dimension = shape ? shape_space.dimension() : 0;
    Eigen::RowVectorXf features = Eigen::RowVectorXf::Zero(9 * num_joints + dimension);
    for (Eigen::Index joint = 0; joint < num_joints; ++joint) {
        if (!visible[static_cast<std::size_t>(joint)]) continue;
        const Eigen::Matrix3d& rotation = input.pose.parent_from_joint[static_cast<std::size_t>(joint)];
        for (int row = 0; row < 3; ++row)
            for (int col = 0; col < 3; ++col)
                features[9 * joint + 3 * row + col] = static_cast<float>(rotation(row, col) - (row == col ? 1.0 : 0.0));
    }
    if (shape) {
        require_input(input.shape_code.size() == dimension,
                      "the shape code has {} numbers where the network's shape space has {}", input.shape_code.size(),
                      dimension);
        for (Eigen::Index k = 0; k < dimension; ++k)
            features[9 * num_joints + k] =
                static_cast<float>(input.shape_code[k] / std::max(shape_space.standard_deviations[k], 1e-12));
    }
    return features;
}

std::vector<Eigen::Matrix3d> reference_rotations(const Skeleton& skeleton, const SkinningWeights& prism_weights,
                                                 const Pose& pose, bool rotation)
{
    if (!rotation)
        return std::vector<Eigen::Matrix3d>(static_cast<std::size_t>(prism_weights.size()),
                                            pose.parent_from_joint.at(0));
    // Rotations do not depend on where the joints are.
    return blend_rotations(prism_weights, forward_kinematics(skeleton, Points::Zero(skeleton.num_joints(), 3), pose));
}

}  // namespace ndg
