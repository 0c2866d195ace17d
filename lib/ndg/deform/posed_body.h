// SPDX-License-Identifier: Apache-2.0
// What a pose gives a body directly, without any solve: joint motions, skinned vertices, prism rotations.
#pragma once

#include "ndg/body/template.h"

#include <vector>

namespace ndg {

/// Skinning weights of every part of a body, made once per template.
class BodyPoser {
public:
    /// Keeps a reference to `body_template`, which must outlive it.
    explicit BodyPoser(const Template& body_template);

    const Template& body_template() const { return *template_; }

    /// Rigid motion of each joint's surroundings, J. Throws Error when the pose has not one rotation a joint.
    std::vector<Eigen::Isometry3d> world_from_rest(const Body& body, const Pose& pose) const;

    /// Linear blend skinning of the bone wrap, N_w x 3: the Dirichlet values of every solve (NDG 3.2, 4.2).
    Points bone_wrap(const Body& body, const std::vector<Eigen::Isometry3d>& world_from_rest) const;
    /// Linear blend skinning of all volume vertices, N_v x 3.
    Points volume(const Body& body, const std::vector<Eigen::Isometry3d>& world_from_rest) const;
    /// Linear blend skinning of the vertices inside the bone wrap, N_i x 3.
    Points interior(const Body& body, const std::vector<Eigen::Isometry3d>& world_from_rest) const;
    /// Linear blend skinning of the whole skin, N_s x 3.
    Points skin(const Body& body, const std::vector<Eigen::Isometry3d>& world_from_rest) const;
    /// R_p of every prism (NDG equation 11), N_p.
    std::vector<Eigen::Matrix3d> prism_rotations(const std::vector<Eigen::Isometry3d>& world_from_rest) const;

    /// Whole skin for display: the volumetric region from the deformed volume vertices (N_v x 3, the last N_w rows are
    /// the skin), head, hands and toes by linear blend skinning. N_s x 3.
    Points display_skin(const Body& body, const std::vector<Eigen::Isometry3d>& world_from_rest,
                        const Eigen::Ref<const Points>& deformed_volume) const;

private:
    const Template* template_;
    SkinningWeights bone_wrap_weights_;
    SkinningWeights volume_weights_;
    SkinningWeights prism_weights_;
};

}  // namespace ndg
