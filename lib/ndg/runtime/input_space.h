// SPDX-License-Identifier: Apache-2.0
// What a network sees: a pose and a body's shape (NDG section 4.4).
//
// Deviations from the paper, the first two exact:
// - The root's rotation is left out (its nine numbers are those of the identity). Without gravity the deformation turns
//   with the root, and output spaces do likewise; the network would only have to learn to ignore it.
// - Joints that move no part of the volume (fingers, jaw, eyes) are left out: the simulation cannot see them.
// - The paper does not say how the shape's code is scaled. Here it is divided by one number, the standard deviation of
//   the first component. Components divided by their own, small and large alike, were as bad as no shape at all.
#pragma once

#include "ndg/body/shape_space.h"
#include "ndg/body/template.h"

#include <string>
#include <vector>

namespace ndg {

/// One row of input: a pose and a body.
struct PoseInput {
    Eigen::VectorXd shape_code;  ///< InputSpace::encode of the body, d
    Pose pose;
};

class InputSpace {
public:
    /// Without `sees_shape` the shape's numbers are missing. Throws InputError when the shape space is not one of the
    /// template's volume.
    InputSpace(const Template& body_template, const ShapeSpace& shape_space, bool sees_shape);

    /// 9 J + d, or 9 J.
    int width() const;
    int num_volume_vertices() const { return static_cast<int>(shape_space_.mean.size() / 3); }
    const ShapeSpace& shape_space() const { return shape_space_; }
    /// m.
    double code_scale() const { return code_scale_; }
    const std::vector<std::string>& joint_names() const { return joint_names_; }
    /// Template::visible_joints.
    const std::vector<int>& visible_joints() const { return visible_joints_; }

    /// The code of a body's rest shape, for PoseInput; encode once a body.
    Eigen::VectorXd encode(const Body& body) const { return encode(body.volume_vertices); }
    Eigen::VectorXd encode(const Eigen::Ref<const Points>& volume_vertices) const
    {
        return shape_space_.encode(volume_vertices);
    }
    /// R_j - I row by row for each joint (zero where it is not seen), then code / code_scale(). Throws InputError
    /// for a wrong number of joints or codes.
    Eigen::RowVectorXf features(const PoseInput& input) const;

private:
    ShapeSpace shape_space_;
    bool sees_shape_;
    double code_scale_;
    std::vector<std::string> joint_names_;
    std::vector<int> visible_joints_;
};

}  // namespace ndg
