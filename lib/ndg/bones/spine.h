// SPDX-License-Identifier: Apache-2.0
// The vertebrae in a pose: they share the turns of the few joints that the skeleton's spine has.
#pragma once

#include "ndg/bones/bone_names.h"
#include "ndg/core/types.h"

#include <array>
#include <vector>

namespace ndg {

/// Levels from below: 0 is L5-S1, i lies below vertebra i, 24 is C0-C1 between atlas and skull.
constexpr int num_spine_levels = num_vertebrae + 1;

/// Of one body. Each joint of spine and neck gives its turn to the levels between the joints beside it, in proportion
/// to how far these levels can bend, turn and lean, those of bending and leaning tilted so that they balance about the
/// joint: vertebrae then stay where the skeleton has them. Between the levels the vertebrae form a chain, which is
/// moved by what is left of the distance to the skeleton (spread along the chain). Above all shares the turn is the
/// joint's, exactly.
class SpineMotion {
public:
    /// `joint_positions`: J x 3 on the standard skeleton. `levels`: 25 x 3, where the vertebrae turn against each
    /// other. `centres`: 24 x 3, of the vertebral bodies. All at rest.
    SpineMotion(const Eigen::Ref<const Points>& joint_positions, const Eigen::Ref<const Points>& levels,
                const Eigen::Ref<const Points>& centres);

    /// world_from_rest of every vertebra. `joints`: world_from_rest of the skeleton's joints.
    std::array<Eigen::Isometry3d, num_vertebrae> vertebrae(const std::vector<Eigen::Isometry3d>& joints) const;

    /// Share of joint k (spine_1 to 5, neck_1 to 2, head) that level i takes of its turn about axis a (0 bending, 1
    /// turning, 2 leaning): shares of a joint sum to one.
    double share(int k, int level, int axis) const { return shares_[k](level, axis); }

private:
    Points levels_, centres_;
    std::vector<int> joints_;                                         ///< of the skeleton, pelvis first
    std::vector<Eigen::Matrix<double, num_spine_levels, 3>> shares_;  ///< of joints_[k + 1]
    std::vector<Eigen::Matrix<double, num_spine_levels, 3>> summed_;  ///< shares of all levels up to this one
    struct Anchor {
        double place;  ///< along the levels
        int vertebra;  ///< whose centre moves as joint `joint` says; num_vertebrae: the highest level
        int joint;
    };
    std::vector<Anchor> anchors_;
    Eigen::VectorXd centre_places_;
};

/// Places of the levels from the vertebrae's meshes (24, fifth lumbar first; at rest, y up, facing +z) and the skull's
/// joint: half-way between the centres of neighbouring vertebral bodies. `centres` receives these, 24 x 3.
Points spine_levels(const std::vector<Points>& vertebrae, const Eigen::Vector3d& head_joint, Points& centres);

}  // namespace ndg
