// SPDX-License-Identifier: Apache-2.0
#include "ndg/procedural/layout.h"

#include "ndg/body/skeleton.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ndg {

namespace {

constexpr double degree = 3.14159265358979323846 / 180.0;

// Wrist to fingertip is 0.108 of stature (Drillis and Contini); knuckle spacing and finger lengths after hand
// measurements of ANSUR (Greiner 1991), a little slimmer and spread so that the fingers stay apart.
const std::array<FingerPlan, 5> finger_plans = {{
    {"thumb", {0.020, 0.022, 0.012}, 38 * degree, 14 * degree, {0.044, 0.034, 0.024}, {0.0150, 0.0118, 0.0105, 0.0085}},
    {"index", {0.092, 0.029, 0.000}, 9 * degree, 4 * degree, {0.041, 0.025, 0.017}, {0.0098, 0.0090, 0.0083, 0.0072}},
    {"middle", {0.095, 0.008, -0.001}, 2 * degree, 5 * degree, {0.045, 0.029, 0.018}, {0.0098, 0.0091, 0.0084, 0.0073}},
    {"ring", {0.090, -0.013, 0.000}, -5 * degree, 6 * degree, {0.041, 0.027, 0.018}, {0.0094, 0.0087, 0.0080, 0.0070}},
    {"pinky",
     {0.081, -0.032, 0.003},
     -13 * degree,
     8 * degree,
     {0.033, 0.019, 0.016},
     {0.0086, 0.0078, 0.0072, 0.0064}},
}};

}  // namespace

const FingerPlan& finger_plan(int finger_idx)
{
    return finger_plans.at(static_cast<std::size_t>(finger_idx));
}

Points finger_points(const BodyLayout& layout, int finger_idx)
{
    const FingerPlan& plan = finger_plan(finger_idx);
    const Eigen::Vector3d wrist = layout.joint("left_hand"), along = layout.arm_axis(), side = layout.thumb_side(),
                          palm = layout.palm_side();
    const double scale = layout.hand_scale();
    Points points(4, 3);
    Eigen::Vector3d x = wrist + scale * (plan.knuckle[0] * along + plan.knuckle[1] * side + plan.knuckle[2] * palm);
    points.row(0) = x.transpose();
    double bend = plan.bend;
    for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d direction =
            std::cos(bend) * (std::cos(plan.spread) * along + std::sin(plan.spread) * side) + std::sin(bend) * palm;
        x += scale * plan.lengths[k] * direction;
        points.row(k + 1) = x.transpose();
        bend += (finger_idx == 0 ? 2 : k == 0 ? 11 : 8) * degree;
    }
    return points;
}

BodyLayout::BodyLayout(const ProceduralParameters& parameters, double girth) : parameters_(parameters), girth_(girth)
{
    unit_ = parameters.stature_m / board_stature;
    trunk_scale_ =
        (board_neck_height - board_hip_height * parameters.leg_length) / (board_neck_height - board_hip_height);
    hand_scale_ = unit_ * (0.5 + 0.5 * parameters.arm_length) * by_sex(0.965, 1.03);
    foot_scale_ = unit_ * (0.5 + 0.5 * parameters.leg_length) * by_sex(0.965, 1.03);
    joints_ = Points::Zero(num_standard_joints, 3);
    place_axis_joints();
    place_arm();
    place_leg();
    const Skeleton& skeleton = standard_skeleton();
    for (int j = 0; j < skeleton.num_joints(); ++j) {
        const std::string& name = skeleton.joint_names[j];
        if (name.rfind("right_", 0) != 0) continue;
        joints_.row(j) = joints_.row(skeleton.joint("left_" + name.substr(6)));
        joints_(j, 0) = -joints_(j, 0);
    }
}

double BodyLayout::height(double board_y) const
{
    const double leg = parameters_.leg_length;
    if (board_y <= board_hip_height) return unit_ * leg * board_y;
    const double hip = unit_ * leg * board_hip_height;
    if (board_y <= board_neck_height) return hip + unit_ * trunk_scale_ * (board_y - board_hip_height);
    return unit_ * board_stature - unit_ * (board_stature - board_y);
}

Eigen::Vector3d BodyLayout::place(double x, double y, double z) const
{
    return {unit_ * x, height(y), unit_ * z};
}

Eigen::Vector3d BodyLayout::joint(const std::string& name) const
{
    return joints_.row(standard_skeleton().joint(name)).transpose();
}

void BodyLayout::set_joint(const std::string& name, const Eigen::Vector3d& position)
{
    joints_.row(standard_skeleton().joint(name)) = position.transpose();
}

void BodyLayout::place_axis_joints()
{
    set_joint("pelvis", place(0.0, 0.955, 0.0));
    set_joint("spine_1", place(0.0, 1.030, -0.030));
    set_joint("spine_2", place(0.0, 1.110, -0.026));
    set_joint("spine_3", place(0.0, 1.190, -0.036));
    set_joint("spine_4", place(0.0, 1.265, -0.050));
    set_joint("spine_5", place(0.0, 1.340, -0.056));
    set_joint("neck_1", place(0.0, 1.432, -0.044));
    set_joint("neck_2", place(0.0, 1.480, -0.026));
    set_joint("head", place(0.0, 1.535, -0.014));
    set_joint("jaw", place(0.0, 1.545, 0.020));
    set_joint("left_eye", place(0.0315, 1.588, 0.068));
    set_joint("left_clavicle", place(0.022, 1.392, 0.028));
}

void BodyLayout::place_arm()
{
    // Biacromial breadth 36.5 to 41.6 cm; the centre of the shoulder lies about 3.5 cm inside the acromion.
    const double shoulder_x = by_sex(0.158, 0.181) * parameters_.shoulder_breadth;
    const Eigen::Vector3d shoulder = place(shoulder_x, 1.367, -0.024);
    const double angle = (43.0 + 3.4 * std::clamp(girth_, 0.0, 3.5)) * degree;  // arms stand off a thicker trunk
    arm_axis_ = Eigen::Vector3d(std::sin(angle), -std::cos(angle), 0.0);
    arm_up_ = Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0);
    const double upper = 0.168 * board_stature * unit_ * parameters_.arm_length;
    const double lower = 0.1545 * board_stature * unit_ * parameters_.arm_length;
    // A slight bend: the elbow lies behind the line from shoulder to wrist.
    const Eigen::Vector3d elbow = shoulder + upper * arm_axis_ - 0.012 * unit_ * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d wrist = shoulder + (upper + lower) * arm_axis_ + 0.004 * unit_ * Eigen::Vector3d::UnitZ();
    set_joint("left_upper_arm", shoulder);
    set_joint("left_forearm", elbow);
    set_joint("left_forearm_twist", 0.5 * (elbow + wrist));
    set_joint("left_hand", wrist);
    for (int f = 0; f < 5; ++f) {
        const Points points = finger_points(*this, f);
        for (int k = 0; k < 3; ++k)
            set_joint(std::string("left_") + finger_plan(f).name + "_" + std::to_string(k + 1),
                      points.row(k).transpose());
    }
}

void BodyLayout::place_leg()
{
    // Hip joint centres: half distance after Seidel et al. 1995, 14 % of the pelvis' breadth inside its crest.
    const double hip_x = by_sex(0.089, 0.086) * (0.5 + 0.5 * parameters_.hip_breadth);
    const Eigen::Vector3d hip = place(hip_x, board_hip_height, 0.004);
    const double stance = 0.062 + 0.016 * std::clamp(girth_, 0.0, 3.2);  // thicker thighs stand further apart
    const Eigen::Vector3d ankle = place(hip_x + stance, 0.066, -0.024);
    const Eigen::Vector3d knee = hip + 0.497 * (ankle - hip) + unit_ * Eigen::Vector3d(-0.004, 0.0, 0.016);
    leg_axis_ = (ankle - hip).normalized();
    leg_front_ = (Eigen::Vector3d::UnitZ() - leg_axis_.z() * leg_axis_).normalized();
    leg_out_ = leg_front_.cross(leg_axis_).normalized();
    if (leg_out_.x() < 0.0) leg_out_ = -leg_out_;
    foot_front_ = Eigen::Vector3d(std::sin(8 * degree), 0.0, std::cos(8 * degree));
    foot_out_ = Eigen::Vector3d(foot_front_.z(), 0.0, -foot_front_.x());
    set_joint("left_thigh", hip);
    set_joint("left_shin", knee);
    set_joint("left_foot", ankle);
    const Eigen::Vector3d ankle_on_floor(ankle.x(), 0.0, ankle.z());
    set_joint("left_toes", ankle_on_floor + foot_scale_ * (0.137 * foot_front_ + 0.004 * foot_out_ +
                                                           0.020 * Eigen::Vector3d::UnitY()));
}

}  // namespace ndg
