// SPDX-License-Identifier: Apache-2.0
// Pronation shared by the forearm, past half a turn and back.
#include "ndg/retarget/import_motions.h"
#include "ndg/retarget/joint_map_proposal.h"
#include "support/support.h"

#include "retarget/foreign_rig.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

using namespace ndg;
using namespace ndg::test;
using Catch::Matchers::Contains;

namespace {

/// A person who stands and turns the left hand about the forearm: degrees in each frame.
MotionClip turning_hand(const std::vector<double>& degrees)
{
    PoseSet still;
    still.clip_names = {"still"};
    still.clip_frame_rates = {100.0};
    for (std::size_t f = 0; f < degrees.size(); ++f) {
        Pose pose;
        pose.parent_from_joint.assign(std::size_t(num_standard_joints), Eigen::Matrix3d::Identity());
        still.poses.push_back(pose);
    }
    MotionClip clip = clip_of(still, plain_rig());
    const int hand = clip.find_joint("LeftHand"), fore = clip.find_joint("LeftForeArm");
    const Eigen::Vector3d bone =
        (clip.zero_pose_positions.row(hand) - clip.zero_pose_positions.row(fore)).transpose().normalized();
    for (std::size_t f = 0; f < degrees.size(); ++f)
        clip.world_from_joint[f][std::size_t(hand)] = rotation_of(std::fmod(degrees[f], 360.0) * degree * bone);
    return clip;
}

/// Degrees by which a joint of ours turns from frame to frame.
std::vector<double> steps(const MotionClip& clip, const std::string& joint, RetargetReport& report)
{
    const std::optional<JointMap> map = find_joint_map(read_joint_maps(config_path("joint-maps")), clip);
    REQUIRE(map);
    RetargetOptions options;
    options.frame_rate = 0.0;
    options.max_joint_speed = 1e9;
    const PoseSet poses = retarget_clip(clip, *map, human_joints(), options, report);
    const auto j = std::size_t(standard_skeleton().joint(joint));
    std::vector<double> result;
    for (int f = 1; f < poses.size(); ++f)
        result.push_back(rotation_angle(poses.poses[std::size_t(f) - 1].parent_from_joint[j],
                                        poses.poses[std::size_t(f)].parent_from_joint[j]) /
                         degree);
    return result;
}

}  // namespace

TEST_CASE("a hand that turns steadily through 400 degrees turns the forearm in steps as even")
{
    for (const double step : {5.0, -5.0, 0.7}) {
        std::vector<double> degrees;
        for (int f = 0; f <= int(400.0 / std::abs(step)); ++f) degrees.push_back(f * step);
        INFO(step << " degrees a frame");
        RetargetReport report;
        const MotionClip clip = turning_hand(degrees);
        for (const char* joint : {"left_forearm_twist", "left_hand"}) {
            const std::vector<double> found = steps(clip, joint, report);
            REQUIRE(found.size() + 1 == degrees.size());
            const auto [least, most] = std::minmax_element(found.begin(), found.end());
            CHECK(*least == Approx(0.5 * std::abs(step)).margin(0.02));
            CHECK(*most == Approx(0.5 * std::abs(step)).margin(0.02));
        }
        CHECK(report.num_new_jumps == 0);
    }
}

TEST_CASE("pronation that trembles about half a turn, or begins beyond it, keeps the forearm still")
{
    for (const double middle : {180.0, -180.0, 300.0}) {
        std::vector<double> degrees;
        for (int f = 0; f < 60; ++f) degrees.push_back(middle + 6.0 * std::sin(1.7 * f));
        INFO(middle);
        RetargetReport report;
        const MotionClip clip = turning_hand(degrees);
        const std::vector<double> found = steps(clip, "left_forearm_twist", report);
        CHECK(*std::max_element(found.begin(), found.end()) < 6.5);
        CHECK(report.num_new_jumps == 0);
    }
}

TEST_CASE("poses left out by a limit name the joint, its angle and the limit")
{
    std::vector<double> degrees;
    for (int f = 0; f < 20; ++f) degrees.push_back(10.0 * f);
    const MotionClip clip = turning_hand(degrees);
    JointMap map = find_joint_map(read_joint_maps(config_path("joint-maps")), clip).value();
    for (JointMapEntry& entry : map.entries) {
        if (entry.joint == "left_hand") entry.limit = 30.5 * degree;
    }
    RetargetOptions options;
    options.frame_rate = 0.0;
    RetargetReport report;
    retarget_clip(clip, map, human_joints(), options, report);
    REQUIRE(report.dropped_joints.size() == 1);
    CHECK(report.dropped_joints[0].joint == "left_hand");
    CHECK(report.dropped_joints[0].num_poses == report.num_dropped_angles);
    CHECK(report.dropped_joints[0].num_poses == 13);
    CHECK(report.dropped_joints[0].limit == Approx(30.5 * degree));
    CHECK(report.dropped_joints[0].max_angle == Approx(95.0 * degree).margin(0.01));
    const std::string json = report_json({report});
    CHECK_THAT(json, Contains("\"joint\": \"left_hand\"") && Contains("\"limit_degrees\": 30.5"));
}

TEST_CASE("bones that end in no joint are aligned only where they point on")
{
    const MotionClip good = turning_hand({0.0, 1.0, 2.0});
    const auto tip = [](MotionClip clip, const std::string& joint, const Eigen::RowVector3d& offset) {
        const int j = clip.find_joint(joint);
        clip.zero_pose_tips.row(j) = clip.zero_pose_positions.row(j) + offset;
        return clip;
    };
    const int hand = good.find_joint("LeftHand"), fore = good.find_joint("LeftForeArm");
    const Eigen::RowVector3d along = good.zero_pose_positions.row(hand) - good.zero_pose_positions.row(fore);
    CHECK(propose_joint_map(good).map.find("left_hand")->toward == "left_middle_1");
    // Folded back, square to the forearm, and the default of an exporter: up.
    for (const Eigen::RowVector3d& offset :
         {Eigen::RowVector3d(-0.3 * along), Eigen::RowVector3d(Eigen::RowVector3d(0, 0, 1).cross(along)),
          Eigen::RowVector3d(0, 10, 0)}) {
        const JointMapProposal proposal = propose_joint_map(tip(good, "LeftHand", offset));
        CHECK(proposal.map.find("left_hand")->toward.empty());
        CHECK(proposal.map.find("right_hand")->toward == "right_middle_1");
        const auto told = std::find_if(proposal.notes.begin(), proposal.notes.end(), [](const std::string& note) {
            return note.find("LeftHand") != std::string::npos && note.find("more than 60") != std::string::npos;
        });
        CHECK(told != proposal.notes.end());
    }
}

TEST_CASE("a foot whose bone points straight down, or backwards, follows the shank")
{
    const MotionClip good = turning_hand({0.0, 1.0, 2.0});
    CHECK(propose_joint_map(good).map.find("left_foot")->sole);
    for (const Eigen::RowVector3d& bone :
         {Eigen::RowVector3d(0, -8, 0), Eigen::RowVector3d(0, -8, -2), Eigen::RowVector3d(0.1, -8, 0.1)}) {
        MotionClip clip = good;
        for (const std::string side : {"Left", "Right"}) {
            const int foot = clip.find_joint(side + "Foot"), toes = clip.find_joint(side + "ToeBase");
            const Eigen::RowVector3d way = clip.zero_pose_tips.row(toes) - clip.zero_pose_positions.row(toes);
            clip.zero_pose_positions.row(toes) = clip.zero_pose_positions.row(foot) + bone;
            clip.zero_pose_tips.row(toes) = clip.zero_pose_positions.row(toes) + way;
            clip.zero_pose_tips.row(foot) = clip.zero_pose_positions.row(toes);
        }
        const JointMapProposal proposal = propose_joint_map(clip);
        CHECK(proposal.map.find("left_foot")->toward.empty());
        CHECK_FALSE(proposal.map.find("right_foot")->sole);
        RetargetReport report;
        RetargetOptions options;
        options.frame_rate = 0.0;
        const PoseSet poses = retarget_clip(clip, proposal.map, human_joints(), options, report);
        REQUIRE(poses.size() == 3);
        const auto foot = std::size_t(standard_skeleton().joint("left_foot"));
        CHECK(rotation_angle(poses.poses[0].parent_from_joint[foot], Eigen::Matrix3d::Identity()) / degree < 15.0);
    }
}
