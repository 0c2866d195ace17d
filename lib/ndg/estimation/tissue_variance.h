// SPDX-License-Identifier: Apache-2.0
// The motion variance of simulated soft tissue, and how it changes with stiffness.
#pragma once

#include "ndg/capture/motion_variance.h"
#include "ndg/dynamics/motion_simulation.h"
#include "ndg/estimation/stiffness_sensitivity.h"

#include <vector>

namespace ndg {

/// One motion to be matched.
struct TargetMotion {
    std::string name;
    std::vector<Pose> poses;       ///< at the step rate
    std::vector<int> frame_steps;  ///< of each captured frame: its step
    double frame_rate_hertz = 60;  ///< of the capture
    MotionVariance captured;       ///< of the measured skin
};
/// From a sequence with poses. Throws InputError as step_poses and motion_variance do.
TargetMotion target_motion(const Avatar& avatar, const MeasuredSkin& skin, const CaptureSequence& sequence,
                           double step_rate_hertz);

/// What is simulated and measured: tissue, its maps, and skin vertices of its volume.
struct VarianceProblem {
    SoftBody tissue;  ///< its moduli are replaced
    SoftBodyPoser poser;
    TissueOptions options;
    DynamicsOptions dynamics;
    std::vector<int> volume_vertices;  ///< V, none of them held
    Points normals;                    ///< V x 3
};

struct TissueVariance {
    MotionVariance variance;
    RowMatrix normal_by_parameter, tangent_by_parameter;  ///< V x P, m^2; no rows without a Jacobian
    int num_unconverged_frames = 0, num_indefinite_steps = 0;
    double seconds = 0;  ///< of one core
};

/// Simulates a motion and measures it at its captured frames. `jacobian`: with sensitivities, which cost several times
/// the simulation. Throws Error where the motion cannot go on.
TissueVariance tissue_variance(const VarianceProblem& problem, const TargetMotion& motion, const StiffnessField& field,
                               const Eigen::VectorXd& parameters, bool jacobian);

}  // namespace ndg
