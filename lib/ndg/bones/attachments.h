// SPDX-License-Identifier: Apache-2.0
// Muscles and tendons stay at the bones they lie at.
#pragma once

#include "ndg/bones/bone_wrap.h"

#include <vector>

namespace ndg {

/// Of a template: the embedded vertices of muscles that lie near bones. What touches a bone moves with it; with the
/// distance that fades into what the volume does with the vertex.
class Attachments {
public:
    Attachments(const BoneList& list, const Template& body_template);

    /// Corrects the rows of those vertices in `anatomy` (N_a x 3, posed). `segments`: motions of the bones.
    void hold(const Eigen::Ref<const Points>& anatomy_rest, const std::vector<Eigen::Isometry3d>& segments,
              Points& anatomy) const;

    /// The vertices, how much of each the bones have (0 to 1), and which bones.
    const std::vector<int>& vertices() const { return vertices_; }
    const std::vector<double>& shares() const { return shares_; }
    const BoneWeights& weights() const { return weights_; }

private:
    std::vector<int> vertices_;
    std::vector<double> shares_;  ///< of the bones in each
    BoneWeights weights_;
};

}  // namespace ndg
