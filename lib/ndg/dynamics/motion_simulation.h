// SPDX-License-Identifier: Apache-2.0
// One motion of one body through time, in blocks from which a run that was broken off goes on.
#pragma once

#include "ndg/dynamics/driven_body.h"
#include "ndg/dynamics/implicit_euler.h"
#include "ndg/dynamics/scene_loads.h"

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace ndg {

/// skinned: that with which skinning moves the first shape. zero: at rest, and jerked along by what is held.
enum class InitialVelocity { skinned, zero };
template <>
inline constexpr EnumName<InitialVelocity> enum_table<InitialVelocity>[] = {{InitialVelocity::skinned, "skinned"},
                                                                            {InitialVelocity::zero, "zero"}};

struct DynamicsOptions {
    double step_rate_hertz = 120;  ///< of Romero et al.
    double frame_rate_hertz = 30;  ///< of what is written
    double hold_seconds = 0;       ///< that the last pose is held
    InitialVelocity initial_velocity = InitialVelocity::skinned;
    double density = 1000;     ///< kg/m^3; fat has some 920, muscle 1060
    int frames_per_block = 8;  ///< frames after which a state is stored and the factor is made anew
    NewtonOptions newton{1e-4, 1e-6, 60};

    /// Steps from one frame to the next. Throws InputError where the frame rate does not divide the step rate.
    int steps_per_frame() const;
    /// Of a motion of so many poses, one a step.
    int num_frames(std::size_t num_poses) const;
    int num_blocks(int num_frames) const { return (num_frames + frames_per_block - 1) / frames_per_block; }
};
void describe(OptionList& list, DynamicsOptions& options);

/// Some frames in a row and the state at the last of them.
struct DynamicBlock {
    std::vector<std::vector<float>> vertices;               ///< per frame N_v * 3, row-major
    std::vector<double> times;                              ///< s
    std::map<std::string, std::vector<double>> statistics;  ///< the names of dynamics_statistics(), one a frame
    DynamicState state;
};
/// iterations, factorizations, cg_iterations (sums over the steps since the frame before), residual_relative
/// and residual_newton (the largest), converged (1: all steps), kinetic_energy_joule, potential_energy_joule (at the
/// frame), seconds (of a core).
const std::vector<std::string>& dynamics_statistics();

/// Sees where a motion starts (step 0) and the end of every step.
using StepObserver = std::function<void(int step, const DrivenPose& pose, const DynamicState& state)>;

/// Keeps references to body and hook. One object a body and a thread.
class MotionSimulation {
public:
    /// `poses`: one a step, at the step rate. Throws InputError for no pose, or as LoadSchedule does.
    MotionSimulation(DrivenBody& body, std::vector<Pose> poses, const SceneLoads& loads, const DynamicsOptions& options,
                     StepHook* hook = nullptr);

    int num_frames() const { return num_frames_; }
    int num_blocks() const { return options_.num_blocks(num_frames_); }
    /// Block `index`; `before`: the state at the end of the one before it, none for the first. What it gives depends on
    /// nothing else. Throws Error where the motion cannot go on: energies that are not finite, skinning that collapses.
    DynamicBlock run(int index, const std::optional<DynamicState>& before);
    /// From now on. The energy that the step minimised is still that of the body.
    void observe(StepObserver observer) { observer_ = std::move(observer); }
    /// Of all steps so far, of one core.
    const NewtonTimes& seconds() const { return seconds_; }

private:
    const Pose& pose_at(int step) const;
    /// What the pose of a step says of the body; the last few are kept.
    const DrivenPose& driven(int step);
    DynamicState initial();
    NewtonResult step(int index, DynamicState& state);
    Points start_of_step(int index, const DynamicState& state, const DrivenPose& now);

    DrivenBody& body_;
    std::vector<Pose> poses_;
    DynamicsOptions options_;
    LoadSchedule loads_;
    StepHook* hook_;
    ImplicitEuler integrator_;
    int num_frames_;
    std::map<int, DrivenPose> driven_;
    NewtonTimes seconds_;
    StepObserver observer_;
};

/// Where each vertex is when its surroundings move from `before` to `after`. Where skinning has (nearly) collapsed at
/// one, it moves as its place at rest does.
Points carry_along(const std::vector<AffineMap>& before, const std::vector<AffineMap>& after, const Points& rest,
                   const Points& positions);

}  // namespace ndg
