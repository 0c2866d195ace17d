// SPDX-License-Identifier: Apache-2.0
#include "ndg/retarget/retarget_units.h"

#include "ndg/core/error.h"

#include <array>
#include <cmath>

namespace ndg {

namespace {

/// Thigh and shin as a share of stature (Drillis and Contini 1966: hip at 0.530, ankle at 0.039).
constexpr double leg_share = 0.491;
constexpr double usual_stature = 1.7;
/// m, dm, cm, mm, inch, foot, and CMU's ":units length 0.45" (inches over 0.45).
constexpr std::array<double, 7> usual_units = {1.0, 0.1, 0.01, 0.001, 0.0254, 0.3048, 0.0254 / 0.45};

Eigen::Vector3d joint_of(const MotionClip& clip, const JointMap& map, const std::string& ours)
{
    const JointMapEntry* entry = map.find(ours);
    return clip.zero_pose_positions.row(clip.find_joint(entry->source)).transpose();
}

/// The coordinate axis nearest to a direction.
Eigen::Vector3d nearest_axis(const Eigen::Vector3d& direction)
{
    int largest = 0;
    direction.cwiseAbs().maxCoeff(&largest);
    return direction[largest] < 0 ? Eigen::Vector3d(-Eigen::Vector3d::Unit(largest)) : Eigen::Vector3d::Unit(largest);
}

std::string axis_name(const Eigen::Vector3d& axis)
{
    for (int k = 0; k < 3; ++k) {
        if (std::abs(axis[k]) > 0.5) return std::string(axis[k] < 0 ? "-" : "+") + "xyz"[k];
    }
    return "";
}

/// From the ankles to the joint of head, neck and shoulders that lies farthest from them.
Eigen::Vector3d standing_direction(const MotionClip& clip, const JointMap& map)
{
    const Eigen::Vector3d ankles = 0.5 * (joint_of(clip, map, "left_foot") + joint_of(clip, map, "right_foot"));
    Eigen::Vector3d longest = 0.5 * (joint_of(clip, map, "left_thigh") + joint_of(clip, map, "right_thigh")) - ankles;
    for (const char* name : {"head", "neck_1"}) {
        if (map.find(name) == nullptr) continue;
        const Eigen::Vector3d way = joint_of(clip, map, name) - ankles;
        if (way.norm() > longest.norm()) longest = way;
    }
    return longest;
}

double leg_length(const MotionClip& clip, const JointMap& map)
{
    double length = 0.0;
    for (const std::string side : {"left_", "right_"}) {
        const Eigen::Vector3d knee = joint_of(clip, map, side + "shin");
        length += 0.5 * (joint_of(clip, map, side + "thigh") - knee).norm();
        length += 0.5 * (joint_of(clip, map, side + "foot") - knee).norm();
    }
    return length;
}

}  // namespace

void describe(OptionList& list, ConventionOptions& options)
{
    list.add("up-axis", options.up, "axis of the BVH and ASF files that points up; auto: as the zero pose");
    list.add("metres-per-unit", options.metres_per_unit,
             "length of the files' unit (m); 0: from the file or the performer's stature", 0, 1000);
}

ClipConventions apply_conventions(MotionClip& clip, const JointMap& map, const ConventionOptions& options)
{
    const std::string missing = missing_source_joint(map, clip);
    require_input(missing.empty(), "clip {}: has no joint \"{}\", which the joint map {} needs", clip.name, missing,
                  map.path);
    ClipConventions result;
    Eigen::Vector3d up = Eigen::Vector3d::UnitY(), front = Eigen::Vector3d::UnitZ();
    result.axes_from = "file";
    if (!clip.axes_known) {
        result.axes_from = options.up ? "flag" : "estimate";
        up = options.up ? unit_vector(*options.up) : nearest_axis(standing_direction(clip, map));
        const Eigen::Vector3d hips = joint_of(clip, map, "left_thigh") - joint_of(clip, map, "right_thigh");
        const Eigen::Vector3d across = hips - up * up.dot(hips);
        require_input(across.norm() > 0.1 * hips.norm() && hips.norm() > 0,
                      "clip {}: its hips lie along the up axis {}", clip.name, axis_name(up));
        front = nearest_axis(across).cross(up);
        Eigen::Matrix3d turn;
        turn.row(0) = up.cross(front).transpose();
        turn.row(1) = up.transpose();
        turn.row(2) = front.transpose();
        if (!turn.isIdentity(0.0)) turn_clip(clip, turn);
    }
    result.up = axis_name(up);
    result.front = axis_name(front);

    const double length = leg_length(clip, map);
    require_input(length > 0, "clip {}: the legs have zero length", clip.name);
    result.metres_per_unit = options.metres_per_unit;
    result.unit_from = "flag";
    if (result.metres_per_unit <= 0) {
        result.metres_per_unit = clip.metres_per_unit;
        result.unit_from = "file";
    }
    if (result.metres_per_unit <= 0) {
        result.unit_from = "estimate";
        double least = HUGE_VAL;
        for (const double unit : usual_units) {
            const double ratio = std::abs(std::log(unit * length / leg_share / usual_stature));
            if (ratio >= least) continue;
            least = ratio;
            result.metres_per_unit = unit;
        }
    }
    result.performer_stature = result.metres_per_unit * length / leg_share;
    return result;
}

}  // namespace ndg
