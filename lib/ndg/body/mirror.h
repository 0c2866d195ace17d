// SPDX-License-Identifier: Apache-2.0
// A template's mirror image in x = 0: which joint, vertex and prism lies opposite which.
#pragma once

#include "ndg/body/template.h"

#include <vector>

namespace ndg {

/// The tessellation of a template is its own mirror image; skin and weights are so nearly. The wraps follow bones and
/// muscles, which are less so: the mirror image of a body is another body.
struct TemplateMirror {
    std::vector<int> joints;     ///< J: the joint of the other side, itself in the middle
    std::vector<int> vertices;   ///< N_v
    std::vector<int> prisms;     ///< N_p
    double skin_residual = 0;    ///< largest distance of a mirrored skin vertex from the one opposite, m
    double wrap_residual = 0;    ///< the same of bone wrap and muscle wrap
    double weight_residual = 0;  ///< largest difference of a mirrored skinning weight from the one opposite

    /// The body seen in the mirror, standing as this one does: N_v x 3.
    Points mirrored(const Eigen::Ref<const Points>& volume_vertices) const;
    /// Rotations diag(-1, 1, 1) R diag(-1, 1, 1), and the root's displacement mirrored.
    Pose mirrored(const Pose& pose) const;
};

/// Found by walking from one pair of opposite triangles to all others. Throws InputError where joints have no opposite,
/// where triangles do not (with how many do), and where the skin is off by more than 10 mm or a weight by half.
TemplateMirror find_mirror(const Template& body_template);

}  // namespace ndg
