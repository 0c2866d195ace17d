// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/geometry/rotation.h"
#include "ndg/motion/motion_files.h"
#include "ndg/retarget/retarget.h"
#include "support/support.h"

#include "motion/human.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <fstream>
#include <map>

using namespace ndg;
using namespace ndg::test;
using Catch::Matchers::Contains;

namespace {

/// The CMU skeleton at its zero pose (proportions of subject 02, units of decimetres), without frames.
MotionClip cmu_skeleton()
{
    MotionClip clip;
    clip.name = "synthetic";
    clip.frame_rate = 120.0;
    const auto add = [&](const std::string& name, const std::string& parent, const Eigen::RowVector3d& bone) {
        const int p = clip.find_joint(parent);
        const auto n = static_cast<Eigen::Index>(clip.joint_names.size());
        clip.joint_names.push_back(name);
        clip.parents.push_back(p);
        clip.zero_pose_positions.conservativeResize(n + 1, 3);
        clip.zero_pose_tips.conservativeResize(n + 1, 3);
        clip.zero_pose_positions.row(n).setZero();
        if (p >= 0) clip.zero_pose_positions.row(n) = clip.zero_pose_tips.row(p);
        clip.zero_pose_tips.row(n) = clip.zero_pose_positions.row(n) + bone;
    };
    add("root", "", {0, 0, 0});
    add("lowerback", "root", {0, 1.1, 0});
    add("upperback", "lowerback", {0, 1.1, 0});
    add("thorax", "upperback", {0, 1.1, 0});
    add("lowerneck", "thorax", {0, 0.9, 0.1});
    add("upperneck", "lowerneck", {0, 0.9, -0.1});
    add("head", "upperneck", {0, 0.9, 0});
    for (const double side : {1.0, -1.0}) {
        const std::string s = side > 0 ? "l" : "r";
        const double sn = std::sin(20 * degree), cs = std::cos(20 * degree);
        add(s + "hipjoint", "root", {side * 0.9, -1.0, 0.3});
        add(s + "femur", s + "hipjoint", {side * 4.2 * sn, -4.2 * cs, 0});
        add(s + "tibia", s + "femur", {side * 4.1 * sn, -4.1 * cs, 0});
        add(s + "foot", s + "tibia", {side * 0.3 * sn, -0.3 * cs, 1.2});
        add(s + "toes", s + "foot", {0, 0, 0.6});
        add(s + "clavicle", "thorax", {side * 2.0, 0.5, 0});
        add(s + "humerus", s + "clavicle", {side * 2.7, 0, 0});
        add(s + "radius", s + "humerus", {side * 1.8, 0, 0});
        add(s + "wrist", s + "radius", {side * 0.9, 0, 0});
        add(s + "hand", s + "wrist", {side * 0.5, 0, 0});
        add(s + "fingers", s + "hand", {side * 0.4, 0, 0});
        add(s + "thumb", s + "wrist", {side * 0.4, 0, 0.4});
    }
    return clip;
}

/// Appends a frame; `local` gives rotations relative to the parent, the others are identity.
void add_frame(MotionClip& clip, const std::map<std::string, Eigen::Matrix3d>& local,
               const Eigen::RowVector3d& root = {0, 0, 0})
{
    std::vector<Eigen::Matrix3d> world(clip.num_joints());
    for (int j = 0; j < clip.num_joints(); ++j) {
        const auto found = local.find(clip.joint_names[j]);
        world[j] = found == local.end() ? Eigen::Matrix3d::Identity() : found->second;
        if (clip.parents[j] >= 0) world[j] = (world[clip.parents[j]] * world[j]).eval();
    }
    clip.world_from_joint.push_back(world);
    clip.root_positions.conservativeResize(clip.num_frames(), 3);
    clip.root_positions.row(clip.num_frames() - 1) = root;
}

Eigen::Matrix3d turn(const Eigen::Vector3d& axis, double degrees)
{
    return Eigen::AngleAxisd(degrees * degree, axis.normalized()).toRotationMatrix();
}

RetargetOptions every_frame()
{
    RetargetOptions options;
    options.frame_rate = 0.0;
    options.max_joint_speed = 1e9;
    options.inverse_kinematics = false;
    return options;
}

Eigen::Vector3d bone(const Points& joints, const std::string& from, const std::string& to)
{
    const Skeleton& skeleton = standard_skeleton();
    return (joints.row(skeleton.joint(to)) - joints.row(skeleton.joint(from))).transpose().normalized();
}

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b)
{
    return std::atan2(a.cross(b).norm(), a.dot(b)) / degree;
}

const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();

}  // namespace

TEST_CASE("the zero pose of a T pose source gives a T pose with the source's legs and flat feet")
{
    MotionClip clip = cmu_skeleton();
    const Eigen::Matrix3d down_left = turn(z, -20), down_right = turn(z, 20);
    add_frame(clip, {});
    add_frame(clip, {{"lfemur", down_left}, {"rfemur", down_right}});
    const JointMap map = read_joint_map(config_path("joint-maps/cmu.json"));
    const Points rest = human_joints();
    RetargetReport report;
    const PoseSet poses = retarget_clip(clip, map, rest, every_frame(), report);
    REQUIRE(poses.size() == 2);
    CHECK(report.mean_direction_error < 1e-10);
    const Points t_pose = posed_joints(rest, poses.poses[0]);
    CHECK(angle_between(bone(t_pose, "left_upper_arm", "left_forearm"), x) < 1e-6);
    CHECK(angle_between(bone(t_pose, "left_forearm", "left_hand"), x) < 1e-6);
    CHECK(angle_between(bone(t_pose, "right_upper_arm", "right_forearm"), -x) < 1e-6);
    CHECK(angle_between(bone(t_pose, "left_thigh", "left_shin"), down_left.transpose() * -y) < 1e-6);
    CHECK(angle_between(bone(t_pose, "pelvis", "spine_5"), bone(rest, "pelvis", "spine_5")) < 1e-6);
    CHECK(angle_between(bone(t_pose, "neck_1", "head"), bone(rest, "neck_1", "head")) < 1e-6);
    // The arm is raised without twist: what faced forward still does.
    const auto motions = forward_kinematics(standard_skeleton(), rest, poses.poses[0]);
    CHECK(angle_between(motions[standard_skeleton().joint("left_upper_arm")].linear() * z, z) < 12.0);

    // With its legs brought together the source stands on flat soles, and so do we: feet as at rest, but for heading.
    const auto standing = forward_kinematics(standard_skeleton(), rest, poses.poses[1]);
    for (const std::string side : {"left_", "right_"}) {
        const Eigen::Matrix3d foot = standing[standard_skeleton().joint(side + "foot")].linear();
        CHECK(angle_between(foot * y, y) < 1e-6);
        const Eigen::Matrix3d toes = standing[standard_skeleton().joint(side + "toes")].linear();
        CHECK(angle_between(toes * y, y) < 1e-6);
        Eigen::Vector3d heading = foot * bone(rest, side + "foot", side + "toes");
        heading.y() = 0.0;
        CHECK(angle_between(heading, z) < 1e-6);
    }
    const Points feet = posed_joints(rest, poses.poses[1]);
    CHECK(angle_between(bone(feet, "left_thigh", "left_shin"), -y) < 1e-6);
}

TEST_CASE("known rotations of the source give the expected limb directions and rotations")
{
    MotionClip clip = cmu_skeleton();
    const Eigen::Matrix3d root = turn({1, 2, 3}, 50), shoulder = turn({1, -1, 2}, 70), elbow = turn(y, -80),
                          pronation = turn(x, 60), wrist = turn(z, 25), hip = turn(x, -60), knee = turn(x, 75),
                          back = turn(x, 30), head = turn(y, 40);
    add_frame(clip, {});
    add_frame(clip, {{"root", root},
                     {"lowerback", back},
                     {"lhumerus", shoulder},
                     {"lradius", elbow},
                     {"lwrist", pronation},
                     {"lhand", wrist},
                     {"rfemur", hip},
                     {"rtibia", knee},
                     {"head", head}});
    const JointMap map = read_joint_map(config_path("joint-maps/cmu.json"));
    const Points rest = human_joints();
    RetargetReport report;
    const PoseSet poses = retarget_clip(clip, map, rest, every_frame(), report);
    const auto& skeleton = standard_skeleton();
    const Points posed = posed_joints(rest, poses.poses[1]);
    const auto motions = forward_kinematics(skeleton, rest, poses.poses[1]);
    CHECK(angle_between(bone(posed, "left_upper_arm", "left_forearm"), root * back * shoulder * x) < 1e-6);
    CHECK(angle_between(bone(posed, "left_forearm", "left_hand"), root * back * shoulder * elbow * x) < 1.0);
    CHECK(angle_between(motions[skeleton.joint("left_forearm")].linear() * bone(rest, "left_forearm", "left_hand"),
                        root * back * shoulder * elbow * x) < 1e-6);
    const Eigen::Vector3d right_leg = turn(z, 20).transpose() * -y;
    CHECK(angle_between(bone(posed, "right_thigh", "right_shin"), root * hip * right_leg) < 1e-6);
    CHECK(angle_between(bone(posed, "right_shin", "right_foot"), root * hip * knee * right_leg) < 1e-6);
    // Trunk and head turn as the source's do.
    const auto rotation_error = [&](const std::string& joint, const Eigen::Matrix3d& expected) {
        return rotation_angle(Eigen::Matrix3d(motions[skeleton.joint(joint)].linear()), expected) / degree;
    };
    CHECK(rotation_error("pelvis", root) < 1e-6);
    CHECK(rotation_error("spine_1", root * turn(x, 18)) < 1e-6);
    CHECK(rotation_error("spine_2", root * back) < 1e-6);
    CHECK(rotation_error("spine_5", root * back) < 1e-6);
    CHECK(rotation_error("neck_2", root * back) < 1e-6);
    CHECK(rotation_error("head", root * back * head) < 1e-6);
    CHECK(rotation_error("jaw", root * back * head) < 1e-6);
    CHECK(rotation_error("left_index_2", motions[skeleton.joint("left_hand")].linear()) < 1e-6);
    // Half of the pronation is in the forearm's twist joint.
    const Eigen::Matrix3d twist = poses.poses[1].parent_from_joint[skeleton.joint("left_forearm_twist")];
    // (the source's elbow axis is a few degrees from ours, of which the twist takes its share).
    CHECK(rotation_angle(twist, Eigen::Matrix3d::Identity()) / degree == Approx(30.0).margin(2.5));
    CHECK((twist * bone(rest, "left_forearm", "left_hand") - bone(rest, "left_forearm", "left_hand")).norm() < 1e-9);
    // The other half is in the hand; bending of the wrist is noise in this source and left out.
    const Eigen::Matrix3d hand = poses.poses[1].parent_from_joint[skeleton.joint("left_hand")];
    CHECK(rotation_angle(hand, twist) / degree < 0.1);
    CHECK(report.mean_direction_error < 1e-10);
}

TEST_CASE("the root follows the source's hips, scaled by leg length")
{
    MotionClip clip = cmu_skeleton();
    add_frame(clip, {}, {3, 9, 4});
    add_frame(clip, {{"root", turn(y, 90)}}, {5, 8, 1});
    const JointMap map = read_joint_map(config_path("joint-maps/cmu.json"));
    const Points rest = human_joints();
    RetargetReport report;
    const PoseSet poses = retarget_clip(clip, map, rest, every_frame(), report);
    const auto& skeleton = standard_skeleton();
    const auto length = [&](const char* a, const char* b) {
        return (rest.row(skeleton.joint(a)) - rest.row(skeleton.joint(b))).norm();
    };
    const double scale = (length("left_thigh", "left_shin") + length("left_shin", "left_foot")) / 8.3;
    const auto hips = [&](int f) {
        const Points posed = posed_joints(rest, poses.poses[f]);
        return Eigen::RowVector3d(0.5 *
                                  (posed.row(skeleton.joint("left_thigh")) + posed.row(skeleton.joint("right_thigh"))));
    };
    // Source hips: root + R (0, -1, 0.3).
    CHECK((hips(0) - Eigen::RowVector3d(0, scale * 8, 0)).norm() < 1e-9);
    CHECK((hips(1) - scale * Eigen::RowVector3d(5 + 0.3 - 3, 7, 1 - 4.3)).norm() < 1e-9);
}

TEST_CASE("decimation, glitches, skipped frames and the joint limit")
{
    MotionClip clip = cmu_skeleton();
    for (int f = 0; f < 100; ++f) {
        // One frame of 40 jumps by 30 degrees: 3600 degrees a second.
        add_frame(clip, {{"lhumerus", turn(y, f == 48 ? 30 : 0)}, {"ltibia", turn(x, f >= 80 ? 0.5 * (f - 80) : 0)}});
    }
    JointMap map = read_joint_map(config_path("joint-maps/cmu.json"));
    const Points rest = human_joints();
    RetargetReport report;
    const PoseSet poses = retarget_clip(clip, map, rest, RetargetOptions(), report);
    CHECK(poses.frame_idx == std::vector<int>{0, 12, 24, 36, 60, 72, 84, 96});
    CHECK(poses.clip_frame_rates == std::vector<double>{120.0});
    CHECK(report.num_frames == 100);
    CHECK(report.num_glitch_frames == 3);
    CHECK(report.num_dropped_glitches == 1);
    CHECK(report.max_joint_speed / degree == Approx(3600.0));

    map.skip_first_frames = 1;
    const PoseSet skipped = retarget_clip(clip, map, rest, RetargetOptions(), report);
    CHECK(skipped.frame_idx == std::vector<int>{1, 13, 25, 37, 61, 73, 85, 97});
    CHECK(report.num_skipped == 1);

    map.skip_first_frames = 0;
    RetargetOptions options;
    options.max_joint_speed = 1e9;
    const PoseSet all = retarget_clip(clip, map, rest, options, report);
    CHECK(all.size() == 9);
    // The arm must be 45 degrees from rest already in the T pose.
    options.max_joint_angle = 50;
    const PoseSet limited = retarget_clip(clip, map, rest, options, report);
    CHECK(limited.size() == 8);
    CHECK(report.num_dropped_angles == 1);

    options.max_joint_angle = 180;
    for (JointMapEntry& entry : map.entries) {
        if (entry.joint == "left_upper_arm") entry.limit = 50 * degree;
    }
    CHECK(retarget_clip(clip, map, rest, options, report).size() == 8);
    CHECK(report.num_dropped_angles == 1);

    PoseSet both = poses;
    append_poses(both, skipped);
    CHECK(both.size() == 16);
    CHECK(both.clip_idx[7] == 0);
    CHECK(both.clip_idx[8] == 1);
    CHECK(both.clip_names.size() == 2);
    map.skip_first_frames = 100;
    CHECK_THROWS_AS(retarget_clip(clip, map, rest, options, report), InputError);
}

TEST_CASE("joint maps are checked")
{
    const test::TemporaryFolder folder;
    const auto check = [&](const std::string& content, const std::string& message) {
        std::ofstream(folder.file("map.json")) << content;
        CHECK_THROWS_AS(read_joint_map(folder.file("map.json")), InputError);
        CHECK_THROWS_WITH(read_joint_map(folder.file("map.json")), Contains("map.json") && Contains(message));
    };
    check("{", "not valid JSON");
    check("[]", "map.json: expected an object, got []");
    check("{}", "has no \"joints\"");
    check(R"({"jonts": {}})", "unknown key \"jonts\"");
    check(R"({"joints": {"tail": "x"}})", "\"tail\" is not one of our joints");
    check(R"({"joints": {"pelvis": {"fraction": 1}}})", "joints.pelvis: has no \"source\"");
    check(R"({"joints": {"pelvis": {"source": "a", "fraction": 2}}})",
          "joints.pelvis.fraction: expected a number in [0, 1], got 2");
    check(R"({"joints": {"pelvis": {"source": "a", "limit_degrees": 200}}})",
          "joints.pelvis.limit_degrees: expected a number in (0, 180], got 200");
    check(R"({"joints": {"pelvis": {"source": "a", "toward": "head"}}})", "both or none");
    check(R"({"joints": {"pelvis": {"source": "a", "toward": "nose", "bone": ["a"]}}})", "\"nose\"");
    check(R"({"joints": {"pelvis": {"source": "a", "twist": true}}})", "joints.pelvis: unknown key \"twist\"");
    check(R"({"joints": {"pelvis": "a"}})", "no entry for \"left_thigh\"");
    check(R"({"skip_first_frames": -1, "joints": {}})", "skip_first_frames: expected an integer >= 0, got -1");

    const JointMap map = read_joint_map(config_path("joint-maps/cmu.json"));
    MotionClip clip = cmu_skeleton();
    CHECK(missing_source_joint(map, clip).empty());
    clip.joint_names[clip.find_joint("lradius")] = "other";
    add_frame(clip, {});
    RetargetReport report;
    CHECK(missing_source_joint(map, clip) == "lradius");
    CHECK_THROWS_WITH(retarget_clip(clip, map, human_joints(), RetargetOptions(), report), Contains("lradius"));
}
