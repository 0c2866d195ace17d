// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/rigid_parts.h"

namespace ndg {

namespace {

int joint_that_carries_most(const SkinningWeights& weights, const AnatomyPart& part, int num_joints)
{
    Eigen::VectorXd carried = Eigen::VectorXd::Zero(num_joints);
    for (int v = part.vertex_begin; v < part.vertex_end; ++v) {
        for (int k = 0; k < max_influences; ++k) carried[weights.joints(v, k)] += weights.weights(v, k);
    }
    Eigen::Index joint = 0;
    carried.maxCoeff(&joint);
    return int(joint);
}

}  // namespace

RigidParts::RigidParts(const Template& body_template) : weights_(body_template.anatomy_weights)
{
    const int num_joints = body_template.skeleton.num_joints();
    for (const AnatomyPart& part : body_template.anatomy_parts) {
        if (part.layer != AnatomyLayer::bone) continue;
        const int joint = joint_that_carries_most(weights_, part, num_joints);
        for (int v = part.vertex_begin; v < part.vertex_end; ++v) {
            weights_.joints.row(v).setZero();
            weights_.weights.row(v).setZero();
            weights_.joints(v, 0) = joint;
            weights_.weights(v, 0) = 1;
        }
    }
}

Points RigidParts::anatomy(const PosedBody& posed, const Eigen::Ref<const Points>& anatomy_rest,
                           const Eigen::Ref<const Points>&)
{
    return linear_blend_skinning(anatomy_rest, weights_, posed.world_from_rest());
}

void register_rigid_parts(MethodTable& table)
{
    table.add({"rigid-parts",
               "Rigid parts",
               "bones rigid, muscles and skin each skinned by itself; differs from lbs in the anatomy",
               {},
               [](const BodyPoser& poser) { return std::make_unique<RigidParts>(poser.body_template()); }});
}

}  // namespace ndg
