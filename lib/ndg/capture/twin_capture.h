// SPDX-License-Identifier: Apache-2.0
// Twins: captures whose truth is known, made by another model than the one that is estimated. A layered body of prisms
// with inertia, whose flesh is of another stiffness from place to place, moves; its skin is seen with noise, its poses
// with errors.
#pragma once

#include "ndg/body/template.h"
#include "ndg/capture/capture.h"
#include "ndg/core/options.h"

#include <cstdint>

namespace ndg {

struct TwinOptions {
    double frame_rate_hertz = 60;
    double noise_millimetre = 1.5;     ///< root mean square displacement of a vertex
    double smooth_noise_share = 0.5;   ///< of its variance: alike over smooth_noise_metre, different in every frame
    double smooth_noise_metre = 0.2;   ///< wavelength
    double pose_error_degrees = 0.15;  ///< standard deviation of each joint's angle about each axis
    double root_error_millimetre = 1;  ///< the same of each coordinate of the root
    double pose_error_hertz = 1;       ///< errors change no faster
    double heterogeneity = 0.4;        ///< standard deviation of the logarithm of stiffness over the body
    double heterogeneity_metre = 0.5;  ///< wavelength of it
};
void describe(OptionList& list, TwinOptions& options);

/// Of each wrap vertex (N_w) of a body, how many times as stiff flesh below it is as its kind; alike left and right.
Eigen::VectorXd hidden_stiffness(const Template& body_template, const Body& body, const TwinOptions& options,
                                 std::uint64_t seed);
/// Of each prism (N_p), from those of its corners.
Eigen::VectorXd prism_stiffness(const Template& body_template, const Eigen::VectorXd& wrap_stiffness);

/// A motion as it was (N_s x 3 and a pose each frame) as it is seen. `sequence_idx`: which of the twin's motions.
CaptureSequence observed(const CaptureSequence& truth, const TwinOptions& options, std::uint64_t seed,
                         int sequence_idx);

}  // namespace ndg
