// SPDX-License-Identifier: Apache-2.0
// Joint angles as clinicians name them, and poses from them.
#pragma once

#include "ndg/body/skeleton.h"

#include <string>
#include <vector>

namespace ndg {

/// One angle of one joint or group of joints, named "part.motion", e.g. "left_hip.flexion", "trunk.turn_left".
/// All are measured from the neutral posture (neutral-zero method, Ryf and Weymann 1995): standing upright, arms
/// hanging, palms towards the thighs, knees, elbows and fingers straight, feet as at rest.
///  pelvis (to the world): tilt_forward, lean_left, turn_left
///  trunk (spine_5 to pelvis), neck (head to spine_5): flexion, bend_left, turn_left; shared among their joints
///  jaw: opening; left_eye, right_eye: up, left
///  and for left_ and right_ each:
///  clavicle: elevation, protraction
///  shoulder (upper arm to spine_5): elevation of the arm from hanging, plane of it (0 sideways, 90 degrees forward),
///      internal_rotation about the upper arm, counted from the minimal rotation that elevates it
///  elbow: flexion; forearm: pronation; wrist: flexion (palmwards), radial_deviation (thumbwards)
///  thumb_1..3: flexion, abduction of thumb_1 (palmwards); index_1.. pinky_3: flexion; spread of the first joints
///      (thumbwards)
///  hip: flexion, abduction, internal_rotation; knee: flexion; ankle: dorsiflexion, inversion; toes: extension
/// Flexion, abduction and rotation about a long bone are taken in this order about moved axes (Grood and Suntay 1983),
/// pronation before the wrist, the
/// turn of the pelvis before its tilt.
const std::vector<std::string>& clinical_angle_names();
/// Index into clinical_angle_names(), -1 where there is none of that name.
int find_clinical_angle(const std::string& name);

/// What an angle turns: joints of ours, the last of them against `base`, about an axis of the neutral posture (0, 1, 2:
/// x to the left, y up, z forward; of the thumb's frame for its joints). The positive angle turns about sign * axis.
struct ClinicalAxis {
    int base = -1;            ///< joint, -1 for the world
    std::vector<int> joints;  ///< those that share the angle, from the base outwards
    int axis = 0;
    double sign = 1.0;
    bool direction = false;  ///< elevation or its plane: not an angle about one of the axes
};
ClinicalAxis clinical_axis(int angle);

/// The neutral posture of a body, and what it takes to pass between angles and poses of it.
class ClinicalFrames {
public:
    /// `joint_positions`: J x 3 rest positions on the standard skeleton, arms hanging or spread to the sides.
    /// Throws InputError where a limb bone has no length.
    explicit ClinicalFrames(const Eigen::Ref<const Points>& joint_positions);

    /// Pose of the given angles (radians, one for each of clinical_angle_names()), the root joint in place.
    Pose pose(const std::vector<double>& angles) const;
    /// The angles of a pose. Of a pose made by pose() they are those it was made from, exactly for groups of one joint
    /// or one angle and where no second angle of a joint reaches 90 degrees.
    std::vector<double> angles(const Pose& pose) const;

    /// Rotation of each joint's surroundings from the rest to the neutral posture, J rotations.
    const std::vector<Eigen::Matrix3d>& world_from_rest() const { return world_from_rest_; }

private:
    std::vector<Eigen::Matrix3d> world_from_rest_;
    Eigen::Matrix3d thumb_frames_[2];  ///< z the axis of flexion, -y along the thumb, left and right
};

}  // namespace ndg
