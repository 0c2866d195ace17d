// SPDX-License-Identifier: Apache-2.0
#include "ndg/retarget/inverse_kinematics.h"

#include "ndg/core/error.h"
#include "ndg/geometry/rotation.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

/// Steps that raise the objective are taken back and damped more, this often.
constexpr int max_damping_raises = 12;

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v)
{
    Eigen::Matrix3d matrix;
    matrix << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
    return matrix;
}

}  // namespace

InverseKinematics::InverseKinematics(const Skeleton& skeleton, const Eigen::Ref<const Points>& joint_positions,
                                     std::vector<int> free_joints, std::vector<int> goal_joints,
                                     const InverseKinematicsOptions& options)
    : skeleton_(skeleton),
      free_joints_(std::move(free_joints)),
      goal_joints_(std::move(goal_joints)),
      is_free_(skeleton.joint_names.size(), false),
      options_(options)
{
    require(joint_positions.rows() == skeleton.num_joints(), "Inverse kinematics: {} joint positions instead of {}",
            joint_positions.rows(), skeleton.num_joints());
    require(
        !free_joints_.empty() && free_joints_.front() == 0 && std::is_sorted(free_joints_.begin(), free_joints_.end()),
        "Inverse kinematics: the free joints must ascend from the root");
    std::vector<int> free_idx(skeleton.joint_names.size(), -1);
    for (std::size_t i = 0; i < free_joints_.size(); ++i) {
        free_idx[free_joints_[i]] = static_cast<int>(i);
        is_free_[free_joints_[i]] = true;
    }
    for (int j = 1; j < skeleton.num_joints(); ++j) {
        if (free_idx[j] < 0) free_idx[j] = free_idx[skeleton.parents[j]];
    }
    for (const int goal : goal_joints_) {
        std::vector<Segment> chain;
        for (int j = goal; skeleton.parents[j] >= 0; j = skeleton.parents[j]) {
            const int parent = skeleton.parents[j];
            const Eigen::Vector3d bone = (joint_positions.row(j) - joint_positions.row(parent)).transpose();
            if (!chain.empty() && chain.back().free_idx == free_idx[parent])
                chain.back().rest += bone;
            else
                chain.push_back({free_idx[parent], bone});
        }
        chains_.push_back(std::move(chain));
    }
}

Points InverseKinematics::positions(const std::vector<Eigen::Matrix3d>& world_from_joint) const
{
    Points result = Points::Zero(static_cast<Eigen::Index>(goal_joints_.size()), 3);
    for (std::size_t g = 0; g < chains_.size(); ++g) {
        for (const Segment& segment : chains_[g]) {
            result.row(g) += (world_from_joint[free_joints_[segment.free_idx]] * segment.rest).transpose();
        }
    }
    return result;
}

RowMatrix InverseKinematics::jacobian(const std::vector<Eigen::Matrix3d>& world_from_joint) const
{
    RowMatrix result = RowMatrix::Zero(3 * chains_.size(), 3 * free_joints_.size());
    for (std::size_t g = 0; g < chains_.size(); ++g) {
        for (const Segment& segment : chains_[g]) {
            const Eigen::Vector3d arm = world_from_joint[free_joints_[segment.free_idx]] * segment.rest;
            result.block<3, 3>(3 * g, 3 * segment.free_idx) -= cross_matrix(arm);
        }
    }
    return result;
}

double InverseKinematics::objective(const std::vector<Eigen::Matrix3d>& world_from_joint,
                                    const std::vector<Eigen::Matrix3d>& reference, const Points& targets) const
{
    double rotations = 0.0;
    for (const int j : free_joints_) {
        rotations += rotation_vector(world_from_joint[j] * reference[j].transpose()).squaredNorm();
    }
    return (positions(world_from_joint) - targets).squaredNorm() / (options_.position_sigma * options_.position_sigma) +
           rotations / (options_.rotation_sigma * options_.rotation_sigma);
}

void InverseKinematics::follow_parents(std::vector<Eigen::Matrix3d>& world_from_joint) const
{
    for (int j = 0; j < skeleton_.num_joints(); ++j) {
        if (!is_free_[j]) world_from_joint[j] = world_from_joint[skeleton_.parents[j]];
    }
}

int InverseKinematics::solve(const std::vector<Eigen::Matrix3d>& reference, const Points& targets,
                             std::vector<Eigen::Matrix3d>& world_from_joint) const
{
    const auto num_unknowns = static_cast<Eigen::Index>(3 * free_joints_.size());
    const double position_weight = 1.0 / (options_.position_sigma * options_.position_sigma);
    const double rotation_weight = 1.0 / (options_.rotation_sigma * options_.rotation_sigma);
    double damping = options_.damping;
    double value = objective(world_from_joint, reference, targets);
    std::vector<Eigen::Matrix3d> trial = world_from_joint;
    Eigen::MatrixXd normal(num_unknowns, num_unknowns);
    Eigen::VectorXd gradient(num_unknowns);
    std::vector<Eigen::Vector3d> arms;
    int steps = 0;
    for (bool moving = true; moving && steps < options_.max_iterations; ++steps) {
        normal.setZero();
        // The gradient of |log R|^2 / 2 by a rotation vector is log R itself; its Hessian is the identity near zero.
        for (std::size_t i = 0; i < free_joints_.size(); ++i) {
            const int j = free_joints_[i];
            const Eigen::Vector3d turned = rotation_vector(world_from_joint[j] * reference[j].transpose());
            gradient.segment<3>(3 * i) = rotation_weight * turned;
        }
        const Points error = positions(world_from_joint) - targets;
        for (std::size_t g = 0; g < chains_.size(); ++g) {
            const std::vector<Segment>& chain = chains_[g];
            const Eigen::Vector3d residual = error.row(g).transpose();
            arms.clear();
            for (const Segment& segment : chain) {
                arms.push_back(world_from_joint[free_joints_[segment.free_idx]] * segment.rest);
            }
            // Blocks of J are -[a]x, so J^T r is a x r, and J^T J is (a.b) I - b a^T.
            for (std::size_t i = 0; i < chain.size(); ++i) {
                const Eigen::Index row = 3 * chain[i].free_idx;
                gradient.segment<3>(row) += position_weight * arms[i].cross(residual);
                for (std::size_t k = 0; k < chain.size(); ++k) {
                    const Eigen::Index col = 3 * chain[k].free_idx;
                    if (col > row) continue;
                    normal.block<3, 3>(row, col) +=
                        position_weight *
                        (arms[i].dot(arms[k]) * Eigen::Matrix3d::Identity() - arms[k] * arms[i].transpose());
                }
            }
        }
        moving = false;
        for (int raise = 0; raise <= max_damping_raises; ++raise) {
            Eigen::MatrixXd damped = normal;
            damped.diagonal().array() += rotation_weight * (1.0 + damping);
            const Eigen::VectorXd step = damped.selfadjointView<Eigen::Lower>().llt().solve(-gradient);
            for (std::size_t i = 0; i < free_joints_.size(); ++i) {
                const int j = free_joints_[i];
                trial[j] = rotation_of(step.segment<3>(3 * i)) * world_from_joint[j];
            }
            const double trial_value = objective(trial, reference, targets);
            // Written so that a step that is not a number counts as a failed one.
            if (trial_value <= value) {
                moving = step.cwiseAbs().maxCoeff() > options_.tolerance;
                for (const int j : free_joints_) world_from_joint[j] = to_quaternion(trial[j]).toRotationMatrix();
                value = trial_value;
                damping = std::max(options_.damping, 0.1 * damping);
                break;
            }
            damping *= 10.0;
        }
    }
    follow_parents(world_from_joint);
    return steps;
}

}  // namespace ndg
