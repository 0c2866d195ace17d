// SPDX-License-Identifier: Apache-2.0
// Joint rotations that bring joints to given positions: damped least squares (Wampler 1986).
#pragma once

#include "ndg/body/skeleton.h"

#include <vector>

namespace ndg {

struct InverseKinematicsOptions {
    double position_sigma = 0.01;  ///< m: a position error that costs as much as
    double rotation_sigma = 0.1;   ///< rad: a rotation away from the reference
    double damping = 1e-3;         ///< share of the rotation term that damps a step, raised tenfold where a step fails
    double tolerance = 1e-7;       ///< rad; ends where no joint moves further in a step
    int max_iterations = 30;
};

/// Minimises over the world rotations R_j of the free joints
///   sum_g |x_g(R) - target_g|^2 / position_sigma^2 + sum_j |log(R_j reference_j^T)|^2 / rotation_sigma^2
/// by steps (J^T J + damping I) w = -J^T r, R_j <- exp(w_j) R_j, J the analytic Jacobian. Goals g are joints, x_g their
/// positions against the root joint. Joints that are not free turn with their parent. Rotations are the world's, not
/// the parent's, so that a corrected trunk carries the limbs along without turning them. The reference decides what
/// positions leave open: twists about bones, joints without a goal below them.
class InverseKinematics {
public:
    /// `joint_positions`: J x 3 rest positions. `free_joints` ascending, the root (0) first. Throws Error otherwise.
    InverseKinematics(const Skeleton& skeleton, const Eigen::Ref<const Points>& joint_positions,
                      std::vector<int> free_joints, std::vector<int> goal_joints,
                      const InverseKinematicsOptions& options = {});

    const std::vector<int>& goal_joints() const { return goal_joints_; }

    /// Positions of the goal joints, G x 3, against the root joint. `world_from_joint`: J rotations.
    Points positions(const std::vector<Eigen::Matrix3d>& world_from_joint) const;
    /// Derivative of the positions by rotation vectors w_j at w = 0, 3 G x 3 F.
    RowMatrix jacobian(const std::vector<Eigen::Matrix3d>& world_from_joint) const;
    double objective(const std::vector<Eigen::Matrix3d>& world_from_joint,
                     const std::vector<Eigen::Matrix3d>& reference, const Points& targets) const;

    /// `targets`: G x 3. `world_from_joint`: J rotations, the start and the result; those of joints that are not free
    /// are set. The objective never rises. Returns the number of steps.
    int solve(const std::vector<Eigen::Matrix3d>& reference, const Points& targets,
              std::vector<Eigen::Matrix3d>& world_from_joint) const;

private:
    /// Part of a goal's position that turns with one free joint.
    struct Segment {
        int free_idx;
        Eigen::Vector3d rest;
    };

    void follow_parents(std::vector<Eigen::Matrix3d>& world_from_joint) const;

    Skeleton skeleton_;
    std::vector<int> free_joints_, goal_joints_;
    std::vector<bool> is_free_;
    std::vector<std::vector<Segment>> chains_;  ///< one a goal
    InverseKinematicsOptions options_;
};

}  // namespace ndg
