// SPDX-License-Identifier: Apache-2.0
// Which way is up in a motion file, and how long its unit is.
#pragma once

#include "ndg/core/axis.h"
#include "ndg/core/options.h"
#include "ndg/retarget/reference_pose.h"

#include <optional>
#include <string>
#include <vector>

namespace ndg {

struct ClipConventions {
    std::string up, front;  ///< axes of the file, "+x" to "-z"
    std::string axes_from;  ///< "file", "flag" or "estimate"
    double metres_per_unit = 0.0;
    std::string unit_from;                ///< likewise
    double performer_stature = 0.0;       ///< m: leg length over 0.491 (Drillis and Contini 1966: 0.245 + 0.246)
    std::string reference = "zero pose";  ///< or "frame 12", "frame 0 of tpose.bvh"
    double reference_turn = 0.0;          ///< rad by which the reference pose leant or faced elsewhere
    std::vector<std::string> warnings;    ///< sentences about what is doubtful
};

struct ConventionOptions {
    std::optional<Axis> up;                      ///< of the file's world and zero pose; none: found
    double metres_per_unit = 0.0;                ///< 0 finds it
    int reference_frame = find_reference_frame;  ///< see find_reference_pose; of `reference` where that is given
    const MotionClip* reference = nullptr;       ///< a clip of the same rig; its zero pose is not searched
};
void describe(OptionList& list, ConventionOptions& options);

/// Gives a clip a zero pose that stands along +y and faces +z, turns its world so that +y is up, and says how it stood
/// and what its unit is. Reference: as find_reference_pose and straighten_zero_pose have it; formats that fix their
/// axes (MotionClip::axes_known) keep their zero pose unless another is asked for. World: where the zero pose stands,
/// left becomes the coordinate axis nearest to the way from its right to its left hip; where a frame is the reference,
/// the world turns only as far as its up axis asks for (z up: -y becomes front). Unit: the flag's, the file's, or of
/// the usual ones (m, dm, cm, mm, inch, foot and CMU's 0.45 inch) the one that brings the performer's stature nearest
/// to 1.7 m. Throws InputError naming clip and value for an up axis along the line of the hips, and as the functions of
/// reference_pose.h do.
ClipConventions apply_conventions(MotionClip& clip, const JointMap& map, const ConventionOptions& options);

}  // namespace ndg
