// SPDX-License-Identifier: Apache-2.0
// Which way is up in a motion file, and how long its unit is.
#pragma once

#include "ndg/core/axis.h"
#include "ndg/core/options.h"
#include "ndg/retarget/joint_map.h"

#include <optional>
#include <string>

namespace ndg {

struct ClipConventions {
    std::string up, front;  ///< axes of the file, "+x" to "-z"
    std::string axes_from;  ///< "file", "flag" or "estimate"
    double metres_per_unit = 0.0;
    std::string unit_from;           ///< likewise
    double performer_stature = 0.0;  ///< m: leg length over 0.491 (Drillis and Contini 1966: 0.245 + 0.246)
};

struct ConventionOptions {
    std::optional<Axis> up;        ///< of the file's world and zero pose; none: found
    double metres_per_unit = 0.0;  ///< 0 finds it
};
void describe(OptionList& list, ConventionOptions& options);

/// Turns a clip so that its zero pose stands along +y and faces +z, and says how it stood and what its unit is.
/// Axes: as the format fixes them (MotionClip::axes_known), otherwise the flag's up or that of the zero pose: up is the
/// coordinate axis nearest to the way from the ankles to the highest of shoulders and head, left the one nearest to the
/// way from right to left hip. Unit: the flag's, the file's, or of the usual ones (m, dm, cm, mm, inch, foot and CMU's
/// 0.45 inch) the one that brings the performer's stature nearest to 1.7 m. Throws InputError naming clip and value for
/// an up axis along the line of the hips.
ClipConventions apply_conventions(MotionClip& clip, const JointMap& map, const ConventionOptions& options);

}  // namespace ndg
