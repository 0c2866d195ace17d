// SPDX-License-Identifier: Apache-2.0
// The flesh about the joints that lose or gain volume first: knees, hips, shoulders.
#pragma once

#include "ndg/body/template.h"

#include <string>
#include <vector>

namespace ndg {

/// Names of the joints: left_knee, right_knee, left_hip...
const std::vector<std::string>& flesh_joint_names();

/// Prisms of a template by joint: those that both bones of the joint move, each by a tenth or more and together by
/// half.
class JointFlesh {
public:
    explicit JointFlesh(const Template& body_template);

    /// Prisms of each of flesh_joint_names(); none where the volume does not reach.
    const std::vector<std::vector<int>>& prisms() const { return prisms_; }
    /// Volume of each joint's flesh over that at rest, less one; 0 where there is none.
    std::vector<double> volume_changes(const Eigen::Ref<const Points>& rest_vertices,
                                       const Eigen::Ref<const Points>& vertices) const;

private:
    const Prisms& all_prisms_;
    std::vector<std::vector<int>> prisms_;
};

}  // namespace ndg
