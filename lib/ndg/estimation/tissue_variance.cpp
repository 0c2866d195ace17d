// SPDX-License-Identifier: Apache-2.0
#include "ndg/estimation/tissue_variance.h"

#include "ndg/capture/step_poses.h"
#include "ndg/core/error.h"
#include "ndg/core/stopwatch.h"

#include <Eigen/LU>

#include <limits>
#include <memory>

namespace ndg {

namespace {

/// Sums from which the variances' derivatives follow: d/dd of the mean of |w|^2 less |mean w|^2 is
/// 2 (mean of w . w' - mean w . mean w').
class VarianceDerivativeSum {
public:
    VarianceDerivativeSum(const VarianceProblem& problem, int num_parameters)
        : problem_(problem),
          products_(RowMatrix::Zero(rows(), num_parameters)),
          normal_products_(products_),
          sums_(RowMatrix::Zero(3 * rows(), num_parameters))
    {
        rest_.resize(rows(), 3);
        for (Eigen::Index v = 0; v < rows(); ++v) rest_.row(v) = problem.tissue.rest.row(vertex(v));
        unit_ = problem.normals.rowwise().normalized();
        mean_ = Points::Zero(rows(), 3);
    }

    void add(const Points& positions, const std::vector<AffineMap>& world_from_unposed,
             const Eigen::MatrixXd& positions_by_parameters)
    {
        for (Eigen::Index v = 0; v < rows(); ++v) {
            const AffineMap& map = world_from_unposed[static_cast<std::size_t>(vertex(v))];
            const Eigen::Matrix3d inverse = map.leftCols<3>().inverse();
            const Eigen::Vector3d x = positions.row(vertex(v)).transpose();
            const Eigen::Vector3d offset = inverse * (x - map.col(3)) - rest_.row(v).transpose();
            const Eigen::Index row = 3 * (vertex(v) - problem_.tissue.num_held);
            const RowMatrix derivative = inverse * positions_by_parameters.middleRows<3>(row);
            mean_.row(v) += offset.transpose();
            sums_.middleRows<3>(3 * v) += derivative;
            products_.row(v) += offset.transpose() * derivative;
            normal_products_.row(v) += unit_.row(v).dot(offset) * (unit_.row(v) * derivative);
        }
        ++count_;
    }

    void finish(TissueVariance& result) const
    {
        result.normal_by_parameter.resize(rows(), products_.cols());
        result.tangent_by_parameter.resize(rows(), products_.cols());
        const double share = 2.0 / count_;
        for (Eigen::Index v = 0; v < rows(); ++v) {
            const Eigen::RowVector3d mean = mean_.row(v) / count_;
            const auto sums = sums_.middleRows<3>(3 * v);
            result.normal_by_parameter.row(v) =
                share * (normal_products_.row(v) - unit_.row(v).dot(mean) * (unit_.row(v) * sums));
            result.tangent_by_parameter.row(v) =
                share * (products_.row(v) - mean * sums) - result.normal_by_parameter.row(v);
        }
    }

private:
    Eigen::Index rows() const { return static_cast<Eigen::Index>(problem_.volume_vertices.size()); }
    int vertex(Eigen::Index v) const { return problem_.volume_vertices[static_cast<std::size_t>(v)]; }

    const VarianceProblem& problem_;
    RowMatrix products_, normal_products_, sums_;
    Points rest_, unit_, mean_;
    int count_ = 0;
};

Points unposed_rows(const VarianceProblem& problem, const Points& positions, const std::vector<AffineMap>& maps)
{
    Points result(static_cast<Eigen::Index>(problem.volume_vertices.size()), 3);
    for (std::size_t v = 0; v < problem.volume_vertices.size(); ++v) {
        const int vertex = problem.volume_vertices[v];
        const AffineMap& map = maps[static_cast<std::size_t>(vertex)];
        const Eigen::Vector3d x = positions.row(vertex).transpose();
        const Eigen::Vector3d u = map.leftCols<3>().inverse() * (x - map.col(3));
        result.row(static_cast<Eigen::Index>(v)) = u.transpose();
    }
    return result;
}

}  // namespace

TargetMotion target_motion(const Avatar& avatar, const MeasuredSkin& skin, const CaptureSequence& sequence,
                           double step_rate_hertz)
{
    TargetMotion motion;
    motion.name = sequence.name;
    motion.poses = step_poses(sequence, step_rate_hertz);
    motion.frame_rate_hertz = sequence.frame_rate_hertz;
    const int steps = steps_per_frame(sequence, step_rate_hertz);
    for (const int number : sequence.frame_numbers)
        motion.frame_steps.push_back((number - sequence.frame_numbers[0]) * steps);
    motion.captured = motion_variance(avatar, skin, sequence);
    return motion;
}

TissueVariance tissue_variance(const VarianceProblem& problem, const TargetMotion& motion, const StiffnessField& field,
                               const Eigen::VectorXd& parameters, bool jacobian)
{
    const double start = thread_seconds();
    SoftBody tissue = problem.tissue;
    field.set_stiffness(parameters, tissue);
    SoftTissueBody body(tissue, problem.poser, problem.options, problem.dynamics.density);
    DynamicsOptions dynamics = problem.dynamics;
    dynamics.frame_rate_hertz = motion.frame_rate_hertz;
    dynamics.frames_per_block = 10000;
    MotionSimulation simulation(body, motion.poses, {}, dynamics);
    require(simulation.num_blocks() == 1, "motion \"{}\" of {} frames is too long", motion.name,
            simulation.num_frames());

    const auto count = static_cast<Eigen::Index>(problem.volume_vertices.size());
    Points rest(count, 3);
    for (Eigen::Index v = 0; v < count; ++v)
        rest.row(v) = tissue.rest.row(problem.volume_vertices[static_cast<std::size_t>(v)]);
    MotionVarianceSum sum(rest, problem.normals);
    VarianceDerivativeSum derivatives(problem, jacobian ? field.num_parameters() : 0);
    std::unique_ptr<StiffnessSensitivity> sensitivity;
    if (jacobian) {
        sensitivity = std::make_unique<StiffnessSensitivity>(body.elastic(), tissue, problem.options, field, parameters,
                                                             body.masses(), 1 / dynamics.step_rate_hertz);
    }
    std::size_t next = 0;
    simulation.observe([&](int step, const DrivenPose& pose, const DynamicState& state) {
        if (step > 0 && jacobian) sensitivity->step(state.positions, pose.world_from_unposed);
        if (next >= motion.frame_steps.size() || motion.frame_steps[next] != step) return;
        ++next;
        sum.add(unposed_rows(problem, state.positions, pose.world_from_unposed));
        if (jacobian) derivatives.add(state.positions, pose.world_from_unposed, sensitivity->positions_by_parameters());
    });
    const DynamicBlock block = simulation.run(0, std::nullopt);
    require(next == motion.frame_steps.size(), "motion \"{}\" ended after {} of {} frames", motion.name, next,
            motion.frame_steps.size());

    TissueVariance result;
    result.variance = sum.variance();
    if (jacobian) {
        derivatives.finish(result);
        result.num_indefinite_steps = sensitivity->num_indefinite();
    }
    for (const double converged : block.statistics.at("converged")) result.num_unconverged_frames += converged == 0;
    result.seconds = thread_seconds() - start;
    return result;
}

}  // namespace ndg
