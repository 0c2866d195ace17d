// SPDX-License-Identifier: Apache-2.0
// A capture beside the statistical body alone and, where there is one, a simulation of the same motions.
#pragma once

#include "ndg/capture/motion_variance.h"
#include "ndg/dynamics/dynamics_file.h"

#include <optional>
#include <string>
#include <vector>

namespace ndg {

/// Where one skin vertex was in unposed space, frame by frame, about its place at rest: along the normal and two
/// directions across it, K x 3, m.
struct SkinTrajectory {
    int skin_vertex = 0;
    Points captured, simulated;  ///< simulated: no rows without a simulation
};

struct MotionMeasure {
    std::string sequence;
    int num_frames = 0, num_missing = 0;
    MotionVariance captured;
    std::optional<MotionVariance> simulated;
    SkinTrajectory liveliest;  ///< of the vertex with the largest variance

    /// D^T D, m^4, against a body that moves by skinning alone, whose variance is zero.
    double skinned_error(VarianceMetric metric) const;
    /// The same of the simulation. Throws Error without one.
    double simulated_error(VarianceMetric metric) const;
    /// Share of the skinned error that the simulation takes away; below zero where it adds to it.
    double reduction(VarianceMetric metric) const;
};

/// Of each sequence of a capture. `simulation`: of the same avatar in motions of the same names at the capture's frame
/// rate, or null. Throws InputError where these differ or the capture has no poses.
std::vector<MotionMeasure> measure_motion(const Avatar& avatar, const MeasuredSkin& skin, const Capture& capture,
                                          const DynamicsReader* simulation);

/// JSON of all measures, lengths in mm (docs/estimation.md), and lines for stdout.
std::string motion_measures_json(const std::string& subject, const std::vector<MotionMeasure>& measures);
std::string motion_measures_table(const std::vector<MotionMeasure>& measures);

}  // namespace ndg
