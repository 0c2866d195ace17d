// SPDX-License-Identifier: Apache-2.0
// The network's input (NDG section 4.4) and the rotation its output is relative to (section 4.3).
//
// Deviations from the paper, both exact:
// - The root's rotation is left out of the input (its nine numbers are those of the identity). Without gravity the
//   deformation turns with the root, and so does R_p, since quaternion blending commutes with a rotation from the left;
//   the network would only have to learn to ignore it.
// - Joints that move no part of the volume (fingers, jaw, eyes) are left out likewise: the simulation cannot see them.
#pragma once

#include "ndg/body/shape_space.h"
#include "ndg/body/template.h"

#include <vector>

namespace ndg {

/// One row of input: a pose and a body.
struct PoseInput {
    Eigen::VectorXd shape_code;  ///< ShapeSpace::encode of the body's volume vertices, d
    Pose pose;
};

/// Joints the input contains: 1 for those that carry, or have a descendant that carries, at least a thousandth of some
/// volume vertex; 0 for the others and for the root. J entries.
std::vector<int> visible_joints(const Template& body_template);

/// 9 J + d numbers: R_j - I row by row for each joint (zero where `visible` is 0), then code / standard deviation.
/// Without `shape` the second part is missing. Throws InputError for a wrong number of joints or codes.
Eigen::RowVectorXf network_features(const PoseInput& input, const std::vector<int>& visible,
                                    const ShapeSpace& shape_space, bool shape);

/// R_p of every prism (NDG equation 11); without `rotation`, the root's rotation for every prism, so that the
/// "no rotation" variant still turns with the root, which its input does not contain.
std::vector<Eigen::Matrix3d> reference_rotations(const Skeleton& skeleton, const SkinningWeights& prism_weights,
                                                 const Pose& pose, bool rotation);

}  // namespace ndg
