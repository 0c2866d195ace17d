// SPDX-License-Identifier: Apache-2.0
#include "ndg/motion/clinical_angles.h"

#include "ndg/core/error.h"
#include "ndg/geometry/rotation.h"
#include "ndg/motion/neutral_posture.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ndg {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// How the rotation of a part is put together from its angles about x, y and z of the neutral posture.
enum class Order {
    xzy,         ///< flexion, abduction, rotation about the long axis
    zxy,         ///< the same for fingers, which bend about the z axis
    yxz,         ///< turn or pronation first: pelvis, wrist
    swing_twist  ///< shoulder: x is the elevation, z the plane, y the rotation
};

struct JointShare {
    int joint;
    std::array<double, 3> share;  ///< of the angles about x, y, z
};

/// A joint or group of joints moved by up to three angles.
struct Part {
    Order order = Order::xzy;
    int base = -1, tip = -1;                  ///< the angles are of the tip's motion against the base's; -1: the world
    std::array<int, 3> angle = {-1, -1, -1};  ///< about x, y, z, into the names; -1: none
    std::array<double, 3> sign = {1, 1, 1};
    std::vector<JointShare> joints;
    int thumb_side = -1;  ///< 0 or 1: axes are those of the thumb
};

/// Share of the clavicle in raising the arm: it rises by about 25 degrees, beginning after 30 degrees of elevation
/// (Inman, Saunders and Abbott 1944; Ludewig et al. 2009 measured 6 to 30 degrees).
double clavicle_rise(double elevation)
{
    constexpr double begin = M_PI / 6, end = M_PI, rise = 25.0 * M_PI / 180.0;
    return rise * std::clamp((std::abs(elevation) - begin) / (end - begin), 0.0, 1.0);
}

class PartList {
public:
    PartList()
    {
        add("pelvis", "", {"pelvis"}, {"tilt_forward", "turn_left", "-lean_left"});
        parts.back().order = Order::yxz;  // tilt and lean are seen from the body, wherever it faces
        // Shares of the segments after the ranges of White and Panjabi 1990: the lumbar spine bends, the thoracic
        // turns.
        add_group("trunk", "pelvis", {"spine_1", "spine_2", "spine_3", "spine_4", "spine_5"},
                  {"flexion", "turn_left", "-bend_left"},
                  {{0.3, 0.05, 0.15}, {0.25, 0.05, 0.2}, {0.2, 0.2, 0.25}, {0.15, 0.35, 0.25}, {0.1, 0.35, 0.15}});
        // Half of the turning of the head is between atlas and axis.
        add_group("neck", "spine_5", {"neck_1", "neck_2", "head"}, {"flexion", "turn_left", "-bend_left"},
                  {{0.35, 0.25, 0.4}, {0.35, 0.25, 0.4}, {0.3, 0.5, 0.2}});
        add("jaw", "head", {"jaw"}, {"opening", "", ""});
        for (const char* eye : {"left_eye", "right_eye"}) add(eye, "head", {eye}, {"-up", "left", ""});
        for (const std::string side : {"left_", "right_"}) add_side(side);
    }

    std::vector<std::string> names;
    std::vector<Part> parts;

private:
    void add_side(const std::string& side)
    {
        add(side + "clavicle", "spine_5", {side + "clavicle"}, {"", "-protraction", "elevation"});
        add(side + "shoulder", "spine_5", {side + "upper_arm"}, {"elevation", "-internal_rotation", "plane"});
        parts.back().order = Order::swing_twist;
        parts.back().sign[2] = 1.0;
        add(side + "elbow", side + "upper_arm", {side + "forearm"}, {"-flexion", "", ""});
        // The forearm twists along its length; half of it is shown by the joint in its middle.
        add_group(side + "wrist", side + "forearm", {side + "forearm_twist", side + "hand"},
                  {"-radial_deviation", "-pronation", "-flexion"}, {{0, 0.5, 0}, {1, 0.5, 1}});
        parts.back().order = Order::yxz;
        names[std::size_t(parts.back().angle[1])] = side + "forearm.pronation";
        add_fingers(side);
        add(side + "hip", "pelvis", {side + "thigh"}, {"-flexion", "-internal_rotation", "abduction"});
        add(side + "knee", side + "thigh", {side + "shin"}, {"flexion", "", ""});
        add(side + "ankle", side + "shin", {side + "foot"}, {"-dorsiflexion", "", "-inversion"});
        add(side + "toes", side + "foot", {side + "toes"}, {"-extension", "", ""});
    }

    void add_fingers(const std::string& side)
    {
        for (const std::string finger : {"thumb", "index", "middle", "ring", "pinky"}) {
            const bool thumb = finger == "thumb";
            for (int k = 1; k <= 3; ++k) {
                const std::string joint = side + finger + "_" + std::to_string(k);
                const std::string base = k == 1 ? side + "hand" : side + finger + "_" + std::to_string(k - 1);
                const std::string second = k > 1 ? "" : thumb ? "abduction" : "-spread";
                add(joint, base, {joint}, {second, "", thumb ? "flexion" : "-flexion"});
                Part& part = parts.back();
                part.order = Order::zxy;
                if (!thumb) continue;
                part.thumb_side = side == "left_" ? 0 : 1;
                // The axis of flexion is made of this side's own positions; the one of abduction lies across it.
                part.sign = {part.thumb_side == 0 ? 1.0 : -1.0, 1.0, 1.0};
            }
        }
    }

    void add(const std::string& name, const std::string& base, const std::vector<std::string>& joints,
             const std::array<std::string, 3>& motions)
    {
        add_group(name, base, joints, motions, {{1, 1, 1}});
    }

    /// `motions`: names of the angles about x, y, z of the left side, with "-" before one that turns the other way.
    void add_group(const std::string& name, const std::string& base, const std::vector<std::string>& joints,
                   const std::array<std::string, 3>& motions, const std::vector<std::array<double, 3>>& shares)
    {
        const Skeleton& skeleton = standard_skeleton();
        Part part;
        if (!base.empty()) part.base = skeleton.joint(base);
        for (std::size_t k = 0; k < joints.size(); ++k) part.joints.push_back({skeleton.joint(joints[k]), shares[k]});
        part.tip = part.joints.back().joint;
        // A mirror image turns the other way about y and z. The eyes look to one side together.
        const bool mirrored = name.rfind("right_", 0) == 0 && name != "right_eye";
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (motions[axis].empty()) continue;
            const bool negative = motions[axis].front() == '-';
            part.sign[axis] = (negative ? -1.0 : 1.0) * (mirrored && axis > 0 ? -1.0 : 1.0);
            part.angle[axis] = static_cast<int>(names.size());
            names.push_back(name + "." + motions[axis].substr(negative ? 1 : 0));
        }
        parts.push_back(part);
    }
};

const PartList& part_list()
{
    static const PartList list;
    return list;
}

bool is_right(const Part& part)
{
    return standard_skeleton().joint_names[std::size_t(part.tip)].rfind("right_", 0) == 0;
}

/// Axis about which the hanging arm rises in a plane: 0 is sideways, 90 degrees forward.
Vector3d elevation_axis(double plane, bool right)
{
    const Vector3d outward((right ? -1.0 : 1.0) * std::cos(plane), 0.0, std::sin(plane));
    return (-Vector3d::UnitY()).cross(outward);
}

/// Rotation of signed angles (x, y, z).
Matrix3d compose(const Part& part, const Vector3d& angle)
{
    switch (part.order) {
        case Order::xzy:
            return about_x(angle.x()) * about_z(angle.z()) * about_y(angle.y());
        case Order::zxy:
            return about_z(angle.z()) * about_x(angle.x()) * about_y(angle.y());
        case Order::yxz:
            return about_y(angle.y()) * about_x(angle.x()) * about_z(angle.z());
        case Order::swing_twist:
            break;
    }
    const Eigen::AngleAxisd swing(angle.x(), elevation_axis(angle.z(), is_right(part)));
    return swing.toRotationMatrix() * about_y(angle.y());
}

double arcsine(double value)
{
    return std::asin(std::clamp(value, -1.0, 1.0));
}

Vector3d decompose(const Part& part, const Matrix3d& r)
{
    Vector3d angle;
    if (part.order == Order::xzy) {
        angle << std::atan2(r(2, 1), r(1, 1)), std::atan2(r(0, 2), r(0, 0)), arcsine(-r(0, 1));
    } else if (part.order == Order::zxy) {
        angle << arcsine(r(2, 1)), std::atan2(-r(2, 0), r(2, 2)), std::atan2(-r(0, 1), r(1, 1));
    } else if (part.order == Order::yxz) {
        angle << arcsine(-r(1, 2)), std::atan2(r(0, 2), r(2, 2)), std::atan2(r(1, 0), r(1, 1));
    } else {
        const Vector3d arm = r * -Vector3d::UnitY();
        const double sideways = is_right(part) ? -arm.x() : arm.x(), across = std::hypot(arm.x(), arm.z());
        angle.x() = std::atan2(across, -arm.y());
        angle.z() = across > 1e-9 ? std::atan2(arm.z(), sideways) : 0.0;
        const Eigen::AngleAxisd swing(angle.x(), elevation_axis(angle.z(), is_right(part)));
        angle.y() = twist_angle(swing.toRotationMatrix().transpose() * r, Vector3d::UnitY());
    }
    return angle;
}

}  // namespace

const std::vector<std::string>& clinical_angle_names()
{
    return part_list().names;
}

int find_clinical_angle(const std::string& name)
{
    const auto& names = clinical_angle_names();
    const auto found = std::find(names.begin(), names.end(), name);
    return found == names.end() ? -1 : static_cast<int>(found - names.begin());
}

ClinicalAxis clinical_axis(int angle)
{
    for (const Part& part : part_list().parts) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (part.angle[axis] != angle) continue;
            ClinicalAxis result;
            result.base = part.base;
            for (const JointShare& joint : part.joints) {
                if (joint.share[axis] > 0.0) result.joints.push_back(joint.joint);
            }
            result.axis = static_cast<int>(axis);
            result.sign = part.sign[axis];
            result.direction = part.order == Order::swing_twist && axis != 1;
            return result;
        }
    }
    throw Error(fmt::format("There is no clinical angle {}", angle));
}

ClinicalFrames::ClinicalFrames(const Eigen::Ref<const Points>& joint_positions)
{
    require(joint_positions.rows() == num_standard_joints, "Clinical angles need {} joint positions, not {}",
            num_standard_joints, joint_positions.rows());
    const NeutralPosture neutral = find_neutral_posture(joint_positions);
    world_from_rest_ = neutral.world_from_rest;
    thumb_frames_[0] = neutral.thumb_frames[0];
    thumb_frames_[1] = neutral.thumb_frames[1];
}

Pose ClinicalFrames::pose(const std::vector<double>& angles) const
{
    require(angles.size() == clinical_angle_names().size(), "{} clinical angles were given instead of {}",
            angles.size(), clinical_angle_names().size());
    const Skeleton& skeleton = standard_skeleton();
    // Motion of each joint against its parent, in the axes of the neutral posture.
    std::vector<Matrix3d> motion(num_standard_joints, Matrix3d::Identity());
    for (const Part& part : part_list().parts) {
        for (const JointShare& joint : part.joints) {
            Vector3d share = Vector3d::Zero();
            for (int axis = 0; axis < 3; ++axis) {
                const int k = part.angle[std::size_t(axis)];
                if (k >= 0) share[axis] = part.sign[std::size_t(axis)] * joint.share[std::size_t(axis)] * angles[k];
            }
            Matrix3d moved = compose(part, share);
            if (part.thumb_side >= 0) {
                const Matrix3d& frame = thumb_frames_[part.thumb_side];
                moved = frame * moved * frame.transpose();
            }
            if (part.order == Order::swing_twist) {
                const auto clavicle = std::size_t(skeleton.parents[std::size_t(joint.joint)]);
                motion[clavicle] = about_z((is_right(part) ? -1.0 : 1.0) * clavicle_rise(share.x())) * motion[clavicle];
                moved = motion[clavicle].transpose() * moved;
            }
            motion[std::size_t(joint.joint)] = moved;
        }
    }
    Pose result = Pose::rest(num_standard_joints);
    for (int j = 0; j < num_standard_joints; ++j) {
        const int parent = skeleton.parents[std::size_t(j)];
        const Matrix3d base = parent < 0 ? Matrix3d::Identity() : world_from_rest_[std::size_t(parent)];
        result.parent_from_joint[std::size_t(j)] =
            base.transpose() * motion[std::size_t(j)] * world_from_rest_[std::size_t(j)];
    }
    return result;
}

std::vector<double> ClinicalFrames::angles(const Pose& pose) const
{
    require(pose.parent_from_joint.size() == num_standard_joints, "A pose has {} joint rotations instead of {}",
            pose.parent_from_joint.size(), num_standard_joints);
    const Skeleton& skeleton = standard_skeleton();
    std::vector<Matrix3d> from_neutral(num_standard_joints), world(num_standard_joints);
    for (int j = 0; j < num_standard_joints; ++j) {
        const int parent = skeleton.parents[std::size_t(j)];
        const Matrix3d& local = pose.parent_from_joint[std::size_t(j)];
        world[std::size_t(j)] = parent < 0 ? local : Matrix3d(world[std::size_t(parent)] * local);
        from_neutral[std::size_t(j)] = world[std::size_t(j)] * world_from_rest_[std::size_t(j)].transpose();
    }
    std::vector<double> result(clinical_angle_names().size(), 0.0);
    for (const Part& part : part_list().parts) {
        const Matrix3d base = part.base < 0 ? Matrix3d::Identity() : from_neutral[std::size_t(part.base)];
        Matrix3d moved = base.transpose() * from_neutral[std::size_t(part.tip)];
        if (part.thumb_side >= 0) {
            const Matrix3d& frame = thumb_frames_[part.thumb_side];
            moved = frame.transpose() * moved * frame;
        }
        const Vector3d angle = decompose(part, moved);
        for (int axis = 0; axis < 3; ++axis) {
            const int k = part.angle[std::size_t(axis)];
            if (k >= 0) result[std::size_t(k)] = part.sign[std::size_t(axis)] * angle[axis];
        }
        if (part.order == Order::swing_twist) {
            // What raising the arm adds to the clavicle is not the clavicle's own.
            const std::string side = is_right(part) ? "right_" : "left_";
            result[std::size_t(find_clinical_angle(side + "clavicle.elevation"))] -= clavicle_rise(angle.x());
        }
    }
    return result;
}

}  // namespace ndg
