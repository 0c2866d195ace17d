// SPDX-License-Identifier: Apache-2.0
#include "ndg/dynamics/motion_simulation.h"

#include "ndg/core/error.h"
#include "ndg/core/stopwatch.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

/// Maps of less volume than this are not undone to carry vertices along.
constexpr double least_carried_volume = 0.05;
/// A step, the two before it and one to come.
constexpr std::size_t kept_poses = 4;

ImplicitEulerOptions integrator_options(const DynamicsOptions& options)
{
    ImplicitEulerOptions result;
    result.time_step_seconds = 1 / options.step_rate_hertz;
    result.newton = options.newton;
    return result;
}

}  // namespace

int DynamicsOptions::steps_per_frame() const
{
    const double steps = step_rate_hertz / frame_rate_hertz;
    const double whole = std::round(steps);
    require_input(whole >= 1 && std::abs(steps - whole) < 1e-9 * steps,
                  "--frame-rate {} does not divide --step-rate {}", frame_rate_hertz, step_rate_hertz);
    return static_cast<int>(whole);
}

int DynamicsOptions::num_frames(std::size_t num_poses) const
{
    const int held_steps = static_cast<int>(std::lround(hold_seconds * step_rate_hertz));
    return 1 + (static_cast<int>(num_poses) - 1 + held_steps) / steps_per_frame();
}

void describe(OptionList& list, DynamicsOptions& options)
{
    list.add("step-rate", options.step_rate_hertz, "time steps a second", 1, 1e5);
    list.add("frame-rate", options.frame_rate_hertz, "frames a second that are written; divides the step rate", 0.1,
             1e5);
    list.add("hold", options.hold_seconds, "seconds that the last pose is held", 0, 1e4);
    list.add("initial-velocity", options.initial_velocity, "velocity at the start: that of the skinning, or none");
    list.add("density", options.density, "density of the flesh, kg/m^3", 1, 1e5);
    list.add("frames-per-block", options.frames_per_block, "frames after which a run can be resumed", 1, 10000);
    describe(list, options.newton);
}

const std::vector<std::string>& dynamics_statistics()
{
    static const std::vector<std::string> names = {"iterations",           "factorizations",         "cg_iterations",
                                                   "residual_relative",    "residual_newton",        "converged",
                                                   "kinetic_energy_joule", "potential_energy_joule", "seconds"};
    return names;
}

Points carry_along(const std::vector<AffineMap>& before, const std::vector<AffineMap>& after, const Points& rest,
                   const Points& positions)
{
    Points carried(positions.rows(), 3);
    for (Eigen::Index v = 0; v < positions.rows(); ++v) {
        const auto k = static_cast<std::size_t>(v);
        const Eigen::Matrix3d from = before[k].leftCols<3>(), to = after[k].leftCols<3>();
        const Eigen::Vector3d at_rest = rest.row(v).transpose(), x = positions.row(v).transpose();
        const Eigen::Vector3d offset = x - (from * at_rest + before[k].col(3));
        const Eigen::Vector3d moved = to * at_rest + after[k].col(3);
        if (from.determinant() < least_carried_volume) {
            carried.row(v) = (moved + offset).transpose();
        } else {
            carried.row(v) = (moved + to * (from.inverse() * offset)).transpose();
        }
    }
    return carried;
}

MotionSimulation::MotionSimulation(DrivenBody& body, std::vector<Pose> poses, const SceneLoads& loads,
                                   const DynamicsOptions& options, StepHook* hook)
    : body_(body),
      poses_(std::move(poses)),
      options_((check_options(options), options)),
      loads_(loads, body),
      hook_(hook),
      integrator_(body.elastic(), body.masses(), integrator_options(options))
{
    require_input(!poses_.empty(), "a motion without poses");
    num_frames_ = options.num_frames(poses_.size());
}

const Pose& MotionSimulation::pose_at(int step) const
{
    return poses_[static_cast<std::size_t>(std::clamp(step, 0, static_cast<int>(poses_.size()) - 1))];
}

const DrivenPose& MotionSimulation::driven(int step)
{
    auto found = driven_.find(step);
    if (found == driven_.end()) {
        while (driven_.size() >= kept_poses) driven_.erase(driven_.begin());
        found = driven_.emplace(step, body_.pose(pose_at(step))).first;
    }
    return found->second;
}

DynamicState MotionSimulation::initial()
{
    const DrivenPose first = body_.pose(pose_at(0));
    body_.set_pose(first);
    DynamicState state;
    state.positions = body_.equilibrium(pose_at(0));
    state.velocities = Points::Zero(body_.num_vertices(), 3);
    if (options_.initial_velocity == InitialVelocity::skinned) {
        // By the difference of the first two poses, as the steps that follow see it.
        const DrivenPose second = body_.pose(pose_at(1));
        const Points moved =
            carry_along(first.world_from_unposed, second.world_from_unposed, body_.rest(), state.positions);
        state.velocities = options_.step_rate_hertz * (moved - state.positions);
    }
    body_.start(state);
    if (observer_) observer_(0, first, state);
    return state;
}

Points MotionSimulation::start_of_step(int index, const DynamicState& state, const DrivenPose& now)
{
    // Carried along as the state is, or with the flesh's own velocity in it: what costs less.
    const DrivenPose& last = driven(index - 1);
    const auto with_held = [&](Points positions) {
        positions.topRows(body_.num_held()) = now.held;
        return positions;
    };
    const Points still =
        with_held(carry_along(last.world_from_unposed, now.world_from_unposed, body_.rest(), state.positions));
    if (index < 2) return still;
    const DrivenPose& earlier = driven(index - 2);
    const Points previous = state.positions - state.velocities / options_.step_rate_hertz;
    const Points expected = carry_along(earlier.world_from_unposed, last.world_from_unposed, body_.rest(), previous);
    const Points moving = with_held(
        carry_along(last.world_from_unposed, now.world_from_unposed, body_.rest(), 2 * state.positions - expected));
    const double energy = integrator_.incremental_potential(state, still);
    return integrator_.incremental_potential(state, moving) < energy ? moving : still;
}

NewtonResult MotionSimulation::step(int index, DynamicState& state)
{
    const double time = index / options_.step_rate_hertz;
    const DrivenPose& now = driven(index);
    body_.set_pose(now);
    Eigen::VectorXd masses;
    Points forces;
    loads_.at(time, masses, forces);
    integrator_.set_loads(masses, forces);
    NewtonResult result = integrator_.step(state, start_of_step(index, state, now), time, hook_);
    if (observer_) observer_(index, driven(index), state);
    return result;
}

DynamicBlock MotionSimulation::run(int index, const std::optional<DynamicState>& before)
{
    require(index >= 0 && index < num_blocks() && before.has_value() == (index > 0),
            "block {} of {} needs the state at the end of the one before it, and the first none", index, num_blocks());
    const int begin = index * options_.frames_per_block;
    const int end = std::min(begin + options_.frames_per_block, num_frames_);
    const int per_frame = options_.steps_per_frame();
    DynamicBlock block;
    block.state = before ? *before : initial();
    integrator_.forget();
    for (int frame = begin; frame < end; ++frame) {
        const double start = thread_seconds();
        std::map<std::string, double> statistics;
        statistics["converged"] = 1;
        for (int s = (frame - 1) * per_frame + 1; frame > 0 && s <= frame * per_frame; ++s) {
            const NewtonResult result = step(s, block.state);
            seconds_ += result.seconds;
            statistics["iterations"] += result.iterations;
            statistics["factorizations"] += result.factorizations;
            statistics["cg_iterations"] += result.cg_iterations;
            statistics["residual_relative"] = std::max(statistics["residual_relative"], result.residual_relative);
            statistics["residual_newton"] = std::max(statistics["residual_newton"], result.residual_newton);
            if (!result.converged()) statistics["converged"] = 0;
        }
        statistics["kinetic_energy_joule"] = integrator_.kinetic_energy(block.state);
        statistics["potential_energy_joule"] = integrator_.potential_energy(block.state.positions);
        statistics["seconds"] = thread_seconds() - start;
        std::vector<float> vertices(static_cast<std::size_t>(block.state.positions.size()));
        Eigen::Map<RowMatrixF>(vertices.data(), block.state.positions.rows(), 3) = block.state.positions.cast<float>();
        block.vertices.push_back(std::move(vertices));
        block.times.push_back(frame / options_.frame_rate_hertz);
        for (const std::string& name : dynamics_statistics()) block.statistics[name].push_back(statistics[name]);
    }
    return block;
}

}  // namespace ndg
