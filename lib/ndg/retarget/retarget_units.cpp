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

/// The reference frame of another clip of the rig, whose up axis counts as this one's.
ReferencePose reference_of(const MotionClip& other, const JointMap& map, const ConventionOptions& options)
{
    const std::string missing = missing_source_joint(map, other);
    require_input(missing.empty(), "clip {}: the reference has no joint \"{}\", which the joint map {} needs",
                  other.name, missing, map.path);
    const StanceJoints joints = stance_joints(other, map);
    const int frame_idx = options.reference_frame >= 0 ? options.reference_frame : straightest_frame;
    return find_reference_pose(other, joints, frame_idx, options.up);
}

void add_warnings(const MotionClip& clip, const ReferencePose& reference, ClipConventions& result)
{
    if (!reference.stands)
        result.warnings.push_back(
            fmt::format("clip {}: its {} is no person who stands straight, and none was found; give --reference-frame "
                        "or --reference",
                        clip.name, result.reference));
    if (reference.up_is_doubtful)
        result.warnings.push_back(fmt::format(
            "clip {}: its zero pose stands along +y, its frames do not: where these stand, give --up-axis", clip.name));
}

}  // namespace

void describe(OptionList& list, ConventionOptions& options)
{
    list.add("up-axis", options.up, "axis of the BVH and ASF files that points up; auto: as the zero pose");
    list.add("metres-per-unit", options.metres_per_unit,
             "length of the files' unit (m); 0: from the file or the performer's stature", 0, 1000);
    list.add("reference-frame", options.reference_frame,
             "frame in which the performer stands straight, which takes the place of the zero pose; -1: the zero pose "
             "where it stands, else the straightest frame; -2: the zero pose as it is",
             zero_pose_is_reference, 1000000000);
}

ClipConventions apply_conventions(MotionClip& clip, const JointMap& map, const ConventionOptions& options)
{
    const std::string missing = missing_source_joint(map, clip);
    require_input(missing.empty(), "clip {}: has no joint \"{}\", which the joint map {} needs", clip.name, missing,
                  map.path);
    ClipConventions result;
    const StanceJoints joints = stance_joints(clip, map);
    ReferencePose reference;
    reference.stands = true;
    result.axes_from = "file";
    const bool asked = options.reference != nullptr || options.reference_frame >= 0;
    if (options.reference != nullptr) {
        reference = reference_of(*options.reference, map, options);
        set_zero_pose(clip, reference_rotations(clip, *options.reference, reference.frame_idx));
        result.reference = fmt::format("frame {} of {}", reference.frame_idx, options.reference->name);
    } else if (!clip.axes_known || asked) {
        reference = find_reference_pose(clip, joints, options.reference_frame, options.up);
        if (reference.frame_idx >= 0) {
            set_zero_pose(clip, std::vector<Eigen::Matrix3d>(clip.world_from_joint[reference.frame_idx]));
            result.reference = fmt::format("frame {}", reference.frame_idx);
        }
    }
    Eigen::Vector3d up = Eigen::Vector3d::UnitY(), front = Eigen::Vector3d::UnitZ();
    const bool whole = reference.frame_idx == zero_pose_is_reference && reference.stands && !reference.zero_pose_lies;
    if (!clip.axes_known) {
        result.axes_from = options.up ? "flag" : "estimate";
        up = reference.up;
        const Eigen::Vector3d hips = joint_of(clip, map, "left_thigh") - joint_of(clip, map, "right_thigh");
        const Eigen::Vector3d across = hips - up * up.dot(hips);
        require_input((across.norm() > 0.1 * hips.norm() && hips.norm() > 0) || (!options.up && !whole),
                      "clip {}: its hips lie along the up axis {}", clip.name, axis_name(up));
        if (whole || options.reference_frame == zero_pose_is_reference) {
            front = nearest_axis(across).cross(up);
        } else if (std::abs(up.z()) > 0.5) {
            front = -up.z() * Eigen::Vector3d::UnitY();
        }
        Eigen::Matrix3d turn;
        turn.row(0) = up.cross(front).transpose();
        turn.row(1) = up.transpose();
        turn.row(2) = front.transpose();
        if (!turn.isIdentity(0.0)) turn_clip(clip, turn);
    }
    // A zero pose that was asked for stays as it is; one that a format fixes has been made by it.
    const bool as_it_is = options.reference_frame == zero_pose_is_reference || (clip.axes_known && !asked);
    if (!as_it_is)
        result.reference_turn =
            straighten_zero_pose(clip, joints, reference.frame_idx == zero_pose_is_reference && reference.stands);
    add_warnings(clip, reference, result);
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
