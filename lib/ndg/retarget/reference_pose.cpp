// SPDX-License-Identifier: Apache-2.0
#include "ndg/retarget/reference_pose.h"

#include "ndg/core/angles.h"
#include "ndg/core/error.h"
#include "ndg/geometry/rotation.h"

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

using Eigen::Vector3d;

constexpr int max_searched_frames = 1000;
/// Frames that stand along an axis decide about it where they are so many, within this of the axis.
constexpr int least_standing_frames = 10;
constexpr double largest_tilt = 30 * radians_per_degree;
/// Turns of a standing zero pose that are a rig's own asymmetry.
constexpr double usual_turn = 3 * radians_per_degree, usual_tilt = 12 * radians_per_degree;

double angle_between(const Vector3d& a, const Vector3d& b)
{
    return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// Unit vector, zero where `vector` has no length.
Vector3d direction(const Vector3d& vector)
{
    const double length = vector.norm();
    return length > 0.0 ? Vector3d(vector / length) : Vector3d(Vector3d::Zero());
}

Vector3d place(const Points& positions, int joint)
{
    return positions.row(joint).transpose();
}

bool both(const std::array<int, 2>& joints)
{
    return joints[0] >= 0 && joints[1] >= 0;
}

Vector3d middle(const Points& positions, const std::array<int, 2>& joints)
{
    return 0.5 * (place(positions, joints[0]) + place(positions, joints[1]));
}

Vector3d across(const Points& positions, const std::array<int, 2>& joints)
{
    return direction(place(positions, joints[0]) - place(positions, joints[1]));
}

Vector3d nearest_axis(const Vector3d& vector)
{
    Eigen::Index largest = 0;
    vector.cwiseAbs().maxCoeff(&largest);
    return (vector[largest] < 0 ? -1.0 : 1.0) * Vector3d::Unit(largest);
}

/// Right-handed frame with the columns left, up, front; up is exact. Identity where the two are parallel.
Eigen::Matrix3d body_frame(const Vector3d& left, const Vector3d& up)
{
    Eigen::Matrix3d frame;
    const Vector3d y = direction(up), x = left - y * y.dot(left);
    if (y.isZero(0.0) || x.norm() < 0.1) return Eigen::Matrix3d::Identity();
    frame.col(0) = x.normalized();
    frame.col(1) = y;
    frame.col(2) = frame.col(0).cross(y);
    return frame;
}

/// How the forearms and upper arms of a frame recommend it: arms before or behind the trunk turn the shoulders.
double arm_cost(const StanceJoints& joints, const Points& positions, const Stance& stance)
{
    const Vector3d front = stance.hips_left.cross(stance.trunk);
    double cost = 0.0;
    for (std::size_t side = 0; side < 2; ++side) {
        if (joints.shoulders[side] < 0 || joints.elbows[side] < 0) continue;
        const Vector3d arm =
            direction(place(positions, joints.elbows[side]) - place(positions, joints.shoulders[side]));
        cost += 0.5 * std::pow(arm.dot(front), 2);
    }
    return cost;
}

struct StandingFrame {
    int frame_idx;
    Stance stance;
    double cost;
};

std::vector<StandingFrame> look_at_frames(const MotionClip& clip, const StanceJoints& joints)
{
    std::vector<StandingFrame> frames;
    const int step = std::max(1, (clip.num_frames() + max_searched_frames - 1) / max_searched_frames);
    for (int f = 0; f < clip.num_frames(); f += step) {
        const Points positions = clip.joint_positions(f);
        const Stance stance = stance_of(joints, positions);
        frames.push_back({f, stance, stance.mean * stance.mean + arm_cost(joints, positions, stance)});
    }
    return frames;
}

/// The axis that most straight frames stand along, +y among equals; nothing where they are fewer than `least`.
std::optional<Vector3d> axis_of_frames(const std::vector<StandingFrame>& frames, int least)
{
    std::optional<Vector3d> best;
    int most = least - 1;
    for (const Axis axis : {Axis::y, Axis::z, Axis::x, Axis::minus_z, Axis::minus_y, Axis::minus_x}) {
        const int count = int(std::count_if(frames.begin(), frames.end(), [&](const StandingFrame& frame) {
            return frame.stance.stands() && angle_between(frame.stance.trunk, unit_vector(axis)) < largest_tilt;
        }));
        if (count <= most) continue;
        most = count;
        best = unit_vector(axis);
    }
    return best;
}

Vector3d axis_of_trunks(const std::vector<StandingFrame>& frames)
{
    Vector3d sum = Vector3d::Zero();
    for (const StandingFrame& frame : frames) sum += frame.stance.trunk;
    return nearest_axis(sum);
}

bool is_below(const MotionClip& clip, int joint, const std::array<int, 2>& tops)
{
    for (; joint >= 0; joint = clip.parents[joint]) {
        if (joint == tops[0] || joint == tops[1]) return true;
    }
    return false;
}

/// The joint that both hang on, -1 where there is none.
int common_parent(const MotionClip& clip, const std::array<int, 2>& joints)
{
    int a = joints[0], b = joints[1];
    while (a != b) (a > b ? a : b) = clip.parents[std::max(a, b)];
    return a;
}

}  // namespace

StanceJoints stance_joints(const MotionClip& clip, const JointMap& map)
{
    const auto joint = [&](const std::string& name) {
        const JointMapEntry* entry = map.find(name);
        return entry == nullptr ? -1 : clip.find_joint(entry->source);
    };
    StanceJoints joints;
    for (std::size_t side = 0; side < 2; ++side) {
        const std::string s = side == 0 ? "left_" : "right_";
        joints.hips[side] = joint(s + "thigh");
        joints.knees[side] = joint(s + "shin");
        joints.ankles[side] = joint(s + "foot");
        joints.toes[side] = joint(s + "toes");
        joints.shoulders[side] = joint(s + "upper_arm");
        joints.elbows[side] = joint(s + "forearm");
        joints.wrists[side] = joint(s + "hand");
    }
    for (const char* name : {"neck_1", "neck_2", "head"}) {
        if (joint(name) >= 0) joints.head = joint(name);
    }
    return joints;
}

Stance stance_of(const StanceJoints& joints, const Points& positions)
{
    Stance stance;
    stance.hips_left = across(positions, joints.hips);
    const Vector3d hips = middle(positions, joints.hips);
    const bool has_shoulders = both(joints.shoulders) && !across(positions, joints.shoulders).isZero(0.0);
    stance.shoulders_left = has_shoulders ? across(positions, joints.shoulders) : stance.hips_left;
    Vector3d top = hips - (middle(positions, joints.ankles) - hips);
    if (joints.head >= 0) top = place(positions, joints.head);
    if (has_shoulders) top = middle(positions, joints.shoulders);
    stance.trunk = direction(top - hips);

    int count = 0;
    const auto add = [&](double angle, double allowed_degrees) {
        const double share = angle / (allowed_degrees * radians_per_degree);
        stance.largest = std::max(stance.largest, share);
        stance.mean += share * share;
        ++count;
    };
    const auto bend = [&](int from, int at, int to) {
        return angle_between(place(positions, at) - place(positions, from),
                             place(positions, to) - place(positions, at));
    };
    for (std::size_t side = 0; side < 2; ++side) {
        const int hip = joints.hips[side], knee = joints.knees[side];
        add(bend(hip, knee, joints.ankles[side]), 35);
        add(angle_between(place(positions, knee) - place(positions, hip), -stance.trunk), 45);
        const int shoulder = joints.shoulders[side], elbow = joints.elbows[side], wrist = joints.wrists[side];
        if (shoulder >= 0 && elbow >= 0 && wrist >= 0) add(bend(shoulder, elbow, wrist), 75);
    }
    add(std::abs(0.5 * M_PI - angle_between(stance.hips_left, stance.trunk)), 25);
    const Vector3d& up = stance.trunk;
    // Both feet stand on one floor.
    const Vector3d leg = hips - middle(positions, joints.ankles);
    const Vector3d step = place(positions, joints.ankles[0]) - place(positions, joints.ankles[1]);
    add(std::atan2(std::abs(step.dot(up)), leg.norm()), 8);
    if (both(joints.toes)) {
        const auto pitch = [&](std::size_t side) {
            return angle_between(place(positions, joints.toes[side]) - place(positions, joints.ankles[side]), up);
        };
        add(std::abs(pitch(0) - pitch(1)), 25);
    }
    add(angle_between(stance.hips_left - up * up.dot(stance.hips_left),
                      stance.shoulders_left - up * up.dot(stance.shoulders_left)),
        40);
    if (has_shoulders && joints.head >= 0) {
        const Vector3d neck = place(positions, joints.head) - top;
        if (neck.norm() > 0.1 * (top - hips).norm()) add(angle_between(neck, stance.trunk), 50);
    }
    stance.mean = std::sqrt(stance.mean / count);
    return stance;
}

ReferencePose find_reference_pose(const MotionClip& clip, const StanceJoints& joints, int frame_idx,
                                  const std::optional<Axis>& up)
{
    require_input(frame_idx < clip.num_frames(), "clip {}: has {} frames, the reference frame is {}", clip.name,
                  clip.num_frames(), frame_idx);
    const std::vector<StandingFrame> frames = look_at_frames(clip, joints);
    const Stance zero = stance_of(joints, clip.zero_pose_positions);
    const auto zero_pose = [&] {
        ReferencePose result;
        result.stands = zero.stands();
        const Vector3d along = nearest_axis(zero.trunk);
        const std::optional<Vector3d> axis = axis_of_frames(frames, least_standing_frames);
        result.up = result.stands ? along : axis.value_or(axis_of_trunks(frames));
        if (result.stands && axis && *axis != along) {
            // Lying people and lying zero poses look alike; +y, the usual axis, decides where it is one of both.
            result.up_is_doubtful = along.y() > 0.5 && !up;
            if (axis->y() > 0.5 || std::abs(along.x()) > 0.5) result.up = *axis;
        }
        if (up) result.up = unit_vector(*up);
        result.zero_pose_lies = result.stands && result.up != along;
        return result;
    };
    const auto frame = [&](int index, const std::optional<Vector3d>& axis) {
        ReferencePose result;
        result.frame_idx = index;
        const Stance stance = stance_of(joints, clip.joint_positions(index));
        result.stands = stance.stands();
        result.up = axis.value_or(nearest_axis(stance.trunk));
        return result;
    };
    std::optional<Vector3d> axis;
    if (up) axis = unit_vector(*up);
    if (frame_idx >= 0) return frame(frame_idx, axis);
    if (frame_idx == zero_pose_is_reference) return zero_pose();
    if (frame_idx == find_reference_frame && zero.stands()) return zero_pose();

    if (!axis) axis = axis_of_frames(frames, 1).value_or(axis_of_trunks(frames));
    int best = 0;
    double least = HUGE_VAL;
    for (const StandingFrame& candidate : frames) {
        const double tilt = angle_between(candidate.stance.trunk, *axis) / largest_tilt;
        const double cost = candidate.cost + tilt * tilt;
        if (cost >= least) continue;
        least = cost;
        best = candidate.frame_idx;
    }
    const ReferencePose result = frame(best, axis);
    const bool nearer = stance_of(joints, clip.joint_positions(best)).mean < zero.mean;
    return result.stands || nearer || frame_idx == straightest_frame ? result : zero_pose();
}

void set_zero_pose(MotionClip& clip, const std::vector<Eigen::Matrix3d>& world_from_joint)
{
    const Points positions = clip.zero_pose_positions, tips = clip.zero_pose_tips;
    for (int j = 0; j < clip.num_joints(); ++j) {
        const int parent = clip.parents[j];
        if (parent >= 0) {
            const Vector3d bone = (positions.row(j) - positions.row(parent)).transpose();
            clip.zero_pose_positions.row(j) =
                clip.zero_pose_positions.row(parent) + (world_from_joint[parent] * bone).transpose();
        }
        const Vector3d tip = (tips.row(j) - positions.row(j)).transpose();
        clip.zero_pose_tips.row(j) = clip.zero_pose_positions.row(j) + (world_from_joint[j] * tip).transpose();
    }
    for (std::vector<Eigen::Matrix3d>& frame : clip.world_from_joint) {
        for (std::size_t j = 0; j < frame.size(); ++j) frame[j] = (frame[j] * world_from_joint[j].transpose()).eval();
    }
}

std::vector<Eigen::Matrix3d> reference_rotations(const MotionClip& clip, const MotionClip& other, int frame_idx)
{
    const double size =
        (clip.zero_pose_positions.colwise().maxCoeff() - clip.zero_pose_positions.colwise().minCoeff()).maxCoeff();
    std::vector<Eigen::Matrix3d> rotations;
    for (int j = 0; j < clip.num_joints(); ++j) {
        const int k = other.find_joint(clip.joint_names[j]);
        require_input(k >= 0, "clip {}: the reference {} has no joint \"{}\"", clip.name, other.name,
                      clip.joint_names[j]);
        rotations.push_back(other.world_from_joint[frame_idx][k]);
        const int parent = clip.parents[j], other_parent = other.parents[k];
        if (parent < 0 || other_parent < 0) continue;
        const Eigen::RowVector3d difference = clip.zero_pose_positions.row(j) - clip.zero_pose_positions.row(parent) -
                                              other.zero_pose_positions.row(k) +
                                              other.zero_pose_positions.row(other_parent);
        require_input(difference.norm() <= 0.02 * size,
                      "clip {}: the bone to \"{}\" differs from that of the reference {} at the zero pose", clip.name,
                      clip.joint_names[j], other.name);
    }
    return rotations;
}

double straighten_zero_pose(MotionClip& clip, const StanceJoints& joints, bool stands)
{
    const Points& positions = clip.zero_pose_positions;
    const Stance stance = stance_of(joints, positions);
    const Vector3d up = Vector3d::UnitY();
    const auto upright = [](const Vector3d& left, const Vector3d& along) {
        return Eigen::Matrix3d(body_frame(left, along).transpose());
    };
    const auto angle = [](const Eigen::Matrix3d& turn) { return rotation_angle(turn, Eigen::Matrix3d::Identity()); };
    std::vector<Eigen::Matrix3d> turns(std::size_t(clip.num_joints()), Eigen::Matrix3d::Identity());
    const Eigen::Matrix3d about_up = upright(stance.hips_left, up);
    if (stands) {
        // The whole person, along the way from the ankles to the top.
        Vector3d top = middle(positions, joints.hips) + stance.trunk;
        if (both(joints.shoulders)) top = middle(positions, joints.shoulders);
        if (joints.head >= 0) top = place(positions, joints.head);
        const Vector3d along = top - middle(positions, joints.ankles);
        const bool leans = angle_between(along, up) > usual_tilt;
        const Eigen::Matrix3d turn = leans ? upright(stance.hips_left, along) : about_up;
        if (angle(turn) <= usual_turn) return 0.0;
        set_zero_pose(clip, std::vector<Eigen::Matrix3d>(turns.size(), turn));
        return angle(turn);
    }
    const Eigen::Matrix3d of_pelvis = upright(stance.hips_left, stance.trunk);
    const Eigen::Matrix3d of_chest = upright(stance.shoulders_left, stance.trunk);
    const int chest = both(joints.shoulders) ? common_parent(clip, joints.shoulders) : -1;
    for (int j = 0; j < clip.num_joints(); ++j) {
        if (is_below(clip, j, joints.hips)) {
            turns[j] = about_up;
        } else {
            turns[j] = chest > 0 && is_below(clip, j, {chest, chest}) ? of_chest : of_pelvis;
        }
    }
    set_zero_pose(clip, turns);
    return angle(of_pelvis);
}

}  // namespace ndg
