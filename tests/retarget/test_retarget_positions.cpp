// SPDX-License-Identifier: Apache-2.0
// Joint positions after retargeting: scaled targets, errors, jumps, reports, and all of the real motions.
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/core/threads.h"
#include "ndg/geometry/rotation.h"
#include "ndg/motion/motion_files.h"
#include "ndg/retarget/retarget.h"
#include "ndg/retarget/retarget_targets.h"
#include "ndg/retarget/retarget_units.h"
#include "support/support.h"

#include "motion/human.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <iostream>

using namespace ndg;
using namespace ndg::test;
using Catch::Matchers::Contains;

namespace {

/// A source rig with our own joints at `positions`, its zero pose, and random motion of all joints but hands and face.
MotionClip own_rig(const Points& positions, int num_frames, double swing)
{
    const Skeleton& skeleton = standard_skeleton();
    MotionClip clip;
    clip.name = "own";
    clip.joint_names = skeleton.joint_names;
    clip.parents = skeleton.parents;
    clip.frame_rate = 30.0;
    clip.zero_pose_positions = positions.rowwise() - positions.row(0);
    clip.zero_pose_tips = clip.zero_pose_positions;
    clip.zero_pose_tips.col(1).array() += 0.05;
    Random random(7, "rig");
    std::vector<Eigen::Vector3d> axes(skeleton.joint_names.size());
    for (Eigen::Vector3d& axis : axes) axis = Eigen::Vector3d(random.normal(), random.normal(), random.normal());
    clip.root_positions = Points::Zero(num_frames, 3);
    for (int f = 0; f < num_frames; ++f) {
        std::vector<Eigen::Matrix3d> world(skeleton.joint_names.size());
        for (int j = 0; j < skeleton.num_joints(); ++j) {
            const Eigen::Matrix3d local = rotation_of(swing * std::sin(0.1 * f + j) * axes[j]);
            world[j] = j == 0 ? local : Eigen::Matrix3d(world[skeleton.parents[j]] * local);
        }
        clip.world_from_joint.push_back(world);
        clip.root_positions.row(f) = Eigen::RowVector3d(0.01 * f, 1.0, 0.02 * f);
    }
    return clip;
}

/// Every joint follows the joint of its own name; limbs are aligned.
JointMap own_map(bool aligned)
{
    JointMap map;
    map.path = "own.json";
    for (const std::string& name : standard_skeleton().joint_names) {
        JointMapEntry entry;
        entry.joint = entry.source = name;
        for (const std::string side : {"left_", "right_"}) {
            for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{
                     {"upper_arm", "forearm"}, {"forearm", "hand"}, {"thigh", "shin"}, {"shin", "foot"}}) {
                if (!aligned || name != side + from) continue;
                entry.toward = entry.bone_to = side + to;
                entry.bone_from = name;
            }
        }
        map.entries.push_back(entry);
    }
    return map;
}

RetargetOptions every_frame()
{
    RetargetOptions options;
    options.frame_rate = 0.0;
    options.max_joint_speed = 1e9;
    return options;
}

}  // namespace

TEST_CASE("targets of a body on itself are its own joints, whatever the unit")
{
    const Points rest = human_joints();
    MotionClip clip = own_rig(rest, 5, 0.3);
    for (const double unit : {1.0, 17.3}) {
        clip.zero_pose_positions = unit * (rest.rowwise() - rest.row(0));
        clip.zero_pose_tips = clip.zero_pose_positions;
        const RotationTransfer transfer(clip, own_map(false), rest);
        CHECK(transfer.scale() == Approx(1.0 / unit));
        const ScaledTargets scaled(transfer, rest);
        // All joints but the root lie on a joint of the source.
        REQUIRE(scaled.landmarks().size() == 59);
        for (int f = 0; f < clip.num_frames(); ++f) {
            Pose pose = Pose::rest(num_standard_joints);
            pose.parent_from_joint = local_rotations(clip.world_from_joint[f]);
            const Points posed = posed_joints(rest, pose), targets = scaled.targets(f);
            const Points uniform = scaled.uniform_targets(f, clip.world_from_joint[f][0]);
            for (int k = 0; k < 59; ++k) {
                const Eigen::RowVector3d expected = posed.row(scaled.landmarks()[k]) - posed.row(0);
                CHECK((targets.row(k) - expected).norm() < 1e-9);
                CHECK((uniform.row(k) - expected).norm() < 1e-9);
            }
        }
        RetargetReport report;
        const PoseSet poses = retarget_clip(clip, own_map(false), rest, every_frame(), report);
        CHECK(report.mean_error < 1e-9);
        CHECK(report.mean_error_uniform < 1e-9);
        for (int f = 0; f < clip.num_frames(); ++f) {
            const auto expected = local_rotations(clip.world_from_joint[f]);
            for (int j = 0; j < num_standard_joints; ++j) {
                CHECK(rotation_angle(poses.poses[f].parent_from_joint[j], expected[j]) < 1e-6);
            }
        }
    }
}

TEST_CASE("limbs of other lengths keep their directions and our lengths")
{
    const Points rest = human_joints();
    Points other = rest;
    const Skeleton& skeleton = standard_skeleton();
    // Longer forearms, shorter shins, arms in a T pose, a broader pelvis.
    for (const std::string side : {"left_", "right_"}) {
        const double sign = side == "left_" ? 1.0 : -1.0;
        const int elbow = skeleton.joint(side + "forearm"), wrist = skeleton.joint(side + "hand");
        other.row(elbow) = other.row(skeleton.joint(side + "upper_arm")) + Eigen::RowVector3d(sign * 0.35, 0, 0);
        other.row(wrist) = other.row(elbow) + Eigen::RowVector3d(sign * 0.4, 0, 0);
        other.row(skeleton.joint(side + "forearm_twist")) = 0.5 * (other.row(elbow) + other.row(wrist));
        for (const char* joint : {"thigh", "shin", "foot", "toes"})
            other(skeleton.joint(side + joint), 0) += sign * 0.04;
        other(skeleton.joint(side + "foot"), 1) += 0.15;
        other(skeleton.joint(side + "toes"), 1) += 0.15;
    }
    const MotionClip clip = own_rig(other, 20, 0.2);
    RetargetReport report;
    const PoseSet poses = retarget_clip(clip, own_map(true), rest, every_frame(), report);
    REQUIRE(poses.size() == 20);
    CHECK(report.mean_error < 1e-3);
    CHECK(report.mean_error_uniform > 0.02);
    for (int f = 0; f < 20; ++f) {
        const Points source = clip.joint_positions(f), ours = posed_joints(rest, poses.poses[f]);
        for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{
                 {"left_upper_arm", "left_forearm"}, {"right_forearm", "right_hand"}, {"left_thigh", "left_shin"}}) {
            const int a = skeleton.joint(from), b = skeleton.joint(to);
            const Eigen::RowVector3d theirs = source.row(b) - source.row(a), mine = ours.row(b) - ours.row(a);
            CHECK(mine.norm() == Approx((rest.row(b) - rest.row(a)).norm()).epsilon(0.01));
            CHECK(mine.normalized().dot(theirs.normalized()) > std::cos(2.5 * degree));
        }
    }
}

TEST_CASE("a trunk of other joints is matched at the neck and the shoulders")
{
    // The source bends at one joint of the spine where our map spreads the bend over five.
    const Points rest = human_joints();
    MotionClip clip = own_rig(rest, 40, 0.0);
    const Skeleton& skeleton = standard_skeleton();
    for (int f = 0; f < clip.num_frames(); ++f) {
        for (int j = 0; j < skeleton.num_joints(); ++j) {
            bool above_waist = false;
            for (int k = j; k >= 0; k = skeleton.parents[k]) above_waist |= k == skeleton.joint("spine_3");
            if (!above_waist) continue;
            clip.world_from_joint[f][j] = rotation_of(Eigen::Vector3d(0.03 * f, 0.01 * f, 0.0));
        }
    }
    JointMap map = own_map(true);
    for (JointMapEntry& entry : map.entries) {
        for (int k = 1; k <= 4; ++k) {
            if (entry.joint != "spine_" + std::to_string(k)) continue;
            entry.source = "pelvis";
            entry.blend_with = "spine_5";
            entry.fraction = 0.2 * k;
        }
    }
    RetargetReport with, without;
    RetargetOptions options = every_frame();
    retarget_clip(clip, map, rest, options, with);
    options.inverse_kinematics = false;
    retarget_clip(clip, map, rest, options, without);
    CHECK(without.mean_error > 0.005);
    CHECK(without.mean_error == Approx(with.mean_error_before));
    CHECK(with.mean_error < 0.2 * without.mean_error);
    CHECK(with.mean_error_uniform < 0.5 * without.mean_error_uniform);
    CHECK(with.max_error < 0.02);
    for (const JointError& error : with.joint_errors) CHECK(error.joint.rfind("spine_", 0) != 0);
}

TEST_CASE("the result does not depend on the number of threads, nor on where pieces begin")
{
    const Points rest = human_joints();
    Points other = rest;
    other.bottomRows(50) *= 1.1;
    const MotionClip clip = own_rig(other, 600, 0.3);
    const JointMap map = own_map(true);
    RetargetReport one, two;
    set_num_threads(1);
    const PoseSet a = retarget_clip(clip, map, rest, every_frame(), one);
    set_num_threads(2);
    const PoseSet b = retarget_clip(clip, map, rest, every_frame(), two);
    set_num_threads(0);
    REQUIRE(a.size() == 600);
    REQUIRE(b.size() == 600);
    bool same = true;
    for (int f = 0; f < 600; ++f) {
        for (int j = 0; j < num_standard_joints; ++j) {
            same = same && a.poses[f].parent_from_joint[j] == b.poses[f].parent_from_joint[j];
        }
    }
    CHECK(same);
    CHECK(report_json({one}) == report_json({two}));
    // Pieces of other frames come to the same poses.
    JointMap later = map;
    later.skip_first_frames = 100;
    const PoseSet shifted = retarget_clip(clip, later, rest, every_frame(), two);
    REQUIRE(shifted.size() == 500);
    double largest = 0.0;
    for (int f = 0; f < 500; ++f) {
        for (int j = 0; j < num_standard_joints; ++j) {
            largest = std::max(
                largest, rotation_angle(shifted.poses[f].parent_from_joint[j], a.poses[f + 100].parent_from_joint[j]));
        }
    }
    CHECK(largest < 1e-5);
}

TEST_CASE("jumps are told apart: the source's own, and those that retargeting made")
{
    const Points rest = human_joints();
    MotionClip clip = own_rig(rest, 10, 0.0);
    const int arm = standard_skeleton().joint("left_upper_arm");
    for (int f = 5; f < 10; ++f) {
        for (int j = 0; j < num_standard_joints; ++j) {
            for (int k = j; k >= 0; k = standard_skeleton().parents[k]) {
                if (k == arm) clip.world_from_joint[f][j] = rotation_of({0.0, 0.0, 80.0 * degree});
            }
        }
    }
    RetargetReport report;
    retarget_clip(clip, own_map(false), rest, every_frame(), report);
    CHECK(report.num_jumps == 1);
    CHECK(report.num_new_jumps == 0);
    CHECK(report.max_jump / degree == Approx(80.0));
    CHECK(report.max_source_jump / degree == Approx(80.0));

    // Half of a rotation that passes through half a turn: the source moves by 2 degrees, half of it by 178. As a twist
    // it is followed.
    MotionClip turn = own_rig(rest, 4, 0.0);
    const int hand = standard_skeleton().joint("left_hand"), forearm = standard_skeleton().joint("left_forearm");
    const Eigen::Vector3d bone = (rest.row(hand) - rest.row(forearm)).transpose().normalized();
    for (int f = 0; f < 4; ++f) turn.world_from_joint[f][hand] = rotation_of((f < 2 ? 179.0 : -179.0) * degree * bone);
    JointMap map = own_map(true);
    for (JointMapEntry& entry : map.entries) {
        if (entry.joint != "left_forearm_twist") continue;
        entry.source = "left_forearm";
        entry.blend_with = "left_hand";
        entry.fraction = 0.5;
    }
    for (const bool twist_only : {false, true}) {
        for (JointMapEntry& entry : map.entries) {
            if (entry.joint == "left_forearm_twist") entry.twist_only = twist_only;
        }
        retarget_clip(turn, map, rest, every_frame(), report);
        CHECK((report.num_new_jumps >= 1) == !twist_only);
        CHECK(report.max_source_jump / degree < 5.0);
    }
}

TEST_CASE("clamped motion keeps to the limits, and violations are counted")
{
    const Points rest = human_joints();
    const MotionClip clip = own_rig(rest, 60, 0.35);
    const JointLimits limits(read_joint_limits(config_path("joint-limits.json")), rest);
    RetargetOptions options = every_frame();
    options.limits = &limits;
    RetargetReport free, clamped;
    const PoseSet before = retarget_clip(clip, own_map(false), rest, options, free);
    options.clamp_limits = true;
    const PoseSet after = retarget_clip(clip, own_map(false), rest, options, clamped);
    REQUIRE(free.limits_checked);
    CHECK(free.num_violating_frames > 30);
    CHECK(clamped.num_violating_frames == free.num_violating_frames);
    CHECK(clamped.limit_hits.size() == free.limit_hits.size());
    CHECK(clamped.limits_clamped);
    CHECK(clamped.mean_error > free.mean_error);
    for (const Pose& pose : after.poses) {
        for (const double excess : limits.excess(pose.parent_from_joint)) CHECK(excess < 1e-6);
    }
    double largest = 0.0;
    for (const Pose& pose : before.poses) {
        for (const double excess : limits.excess(pose.parent_from_joint)) largest = std::max(largest, excess);
    }
    double reported = 0.0;
    for (const LimitHits& hits : free.limit_hits) reported = std::max(reported, hits.max_excess);
    CHECK(reported == Approx(largest));
}

TEST_CASE("units and axes come from the file, a flag or the performer")
{
    const Points rest = human_joints();
    const JointMap map = own_map(false);
    Eigen::Matrix3d z_up;  // y up, facing +z, to z up, facing -y
    z_up << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    MotionClip clip = own_rig(rest * 100.0, 2, 0.2);
    const MotionClip upright = clip;
    turn_clip(clip, z_up);
    ClipConventions found = apply_conventions(clip, map, {});
    CHECK(found.up == "+z");
    CHECK(found.front == "-y");
    CHECK(found.axes_from == "estimate");
    CHECK(found.metres_per_unit == 0.01);
    CHECK(found.unit_from == "estimate");
    CHECK(found.performer_stature == Approx(0.825 / 0.491).epsilon(0.02));
    CHECK((clip.zero_pose_positions - upright.zero_pose_positions).norm() < 1e-9);
    CHECK((clip.root_positions - upright.root_positions).norm() < 1e-12);
    CHECK((clip.world_from_joint[1][5] - upright.world_from_joint[1][5]).norm() < 1e-12);

    clip = upright;
    turn_clip(clip, z_up);
    ConventionOptions options;
    options.up = Axis::z;
    options.metres_per_unit = 0.02;
    found = apply_conventions(clip, map, options);
    CHECK(found.axes_from == "flag");
    CHECK(found.front == "-y");
    CHECK(found.unit_from == "flag");
    CHECK(found.metres_per_unit == 0.02);
    CHECK((clip.zero_pose_positions - upright.zero_pose_positions).norm() < 1e-9);

    clip = upright;
    clip.axes_known = true;
    clip.metres_per_unit = 0.0254;
    found = apply_conventions(clip, map, {});
    CHECK(found.axes_from == "file");
    CHECK(found.unit_from == "file");
    CHECK((clip.zero_pose_positions - upright.zero_pose_positions).norm() == 0.0);
    clip.axes_known = false;
    options.up = Axis::minus_x;
    CHECK_THROWS_WITH(apply_conventions(clip, map, options), Contains("own: its hips lie along the up axis -x"));
}

TEST_CASE("all real motions are imported, near to their source, without jumps of our own", "[data]")
{
    const std::string data = test::data_folder();
    if (data.empty()) return;
    const Points rest = human_joints();
    const std::vector<JointMap> maps = read_joint_maps(config_path("joint-maps"));
    std::vector<RetargetReport> cmu, all;
    for (const MotionFile& file : find_motion_files({data + "/motion"})) {
        if (!file.skip_reason.empty()) continue;
        INFO(file.path);
        MotionClip clip = read_motion(file);
        const std::optional<JointMap> map = find_joint_map(maps, clip);
        REQUIRE(map);
        const ClipConventions found = apply_conventions(clip, *map, {});
        CHECK(found.performer_stature > 1.5);
        CHECK(found.performer_stature < 1.95);
        RetargetReport report;
        const PoseSet poses = retarget_clip(clip, *map, rest, RetargetOptions(), report);
        CHECK(poses.size() > 0);
        CHECK(report.num_new_jumps == 0);
        CHECK(report.mean_error < 0.02);
        CHECK(report.mean_error < report.mean_error_before);
        CHECK(report.mean_direction_error < 3.0 * degree);
        all.push_back(report);
        if (file.path.find("/cmu_") != std::string::npos) cmu.push_back(report);
    }
    CHECK(all.size() >= 70);
    REQUIRE(cmu.size() >= 30);
    const RetargetSummary summary = summarise(cmu);
    std::cout << report_table(cmu).substr(report_table(cmu).rfind("clips, ") - 3);
    CHECK(summary.median_error < 0.02);
}
