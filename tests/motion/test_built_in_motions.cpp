// SPDX-License-Identifier: Apache-2.0
// The motions of configs/motions.
#include "ndg/geometry/rotation.h"
#include "ndg/motion/joint_limits.h"
#include "ndg/motion/keyframes.h"
#include "ndg/motion/motion_files.h"
#include "support/support.h"

#include "motion/human.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>
#include <limits>

using namespace ndg;
using namespace ndg::test;

TEST_CASE("every built-in motion is read, smooth and within human ranges")
{
    int num_motions = 0, num_poses = 0;
    for (const MotionFile& file : find_motion_files({config_path("motions")})) {
        CHECK(file.keyframes);
        CHECK(file.skip_reason.empty());
    }
    const Points rest = human_joints();
    const ClinicalFrames frames(rest);
    for (const auto& entry : std::filesystem::directory_iterator(config_path("motions"))) {
        INFO(entry.path());
        REQUIRE(is_keyframe_motion(entry.path().string()));
        const KeyframeMotion motion = read_keyframe_motion(entry.path().string());
        CHECK(motion.licence.find("Apache-2.0") != std::string::npos);
        const PoseSet poses = keyframe_poses(motion, rest, 0.0);
        CHECK(poses.size() == motion.num_frames());
        CHECK(poses.frame_idx.back() == motion.num_frames() - 1);
        double fastest = 0;
        for (int f = 0; f + 1 < poses.size(); ++f) {
            for (int j = 0; j < num_standard_joints; ++j) {
                fastest = std::max(fastest, rotation_angle(poses.poses[f].parent_from_joint[j],
                                                           poses.poses[f + 1].parent_from_joint[j]));
            }
        }
        // A pitcher's upper arm turns at up to 7000 degrees a second; importing drops frames above 1500.
        CHECK(fastest * motion.frame_rate < 1400 * degree);
        for (const Pose& pose : poses.poses) {
            const std::vector<double> angles = frames.angles(pose);
            for (const std::string side : {"left_", "right_"}) {
                const double knee = angles[std::size_t(find_clinical_angle(side + "knee.flexion"))];
                const double elbow = angles[std::size_t(find_clinical_angle(side + "elbow.flexion"))];
                CHECK((knee > -1 * degree && knee < 150 * degree));
                CHECK((elbow > -1 * degree && elbow < 150 * degree));
            }
        }
        ++num_motions;
        num_poses += keyframe_poses(motion, rest, 10.0).size();
    }
    CHECK(num_motions >= 4);
    CHECK(num_poses > 1000);
}

TEST_CASE("built-in motions keep to published ranges of motion, or nearly")
{
    const Points rest = human_joints();
    const JointLimits limits(read_joint_limits(config_path("joint-limits.json")), rest);
    int num_checked = 0, num_outside = 0;
    for (const MotionFile& file : find_motion_files({config_path("motions")})) {
        const PoseSet poses = keyframe_poses(read_keyframe_motion(file.path), rest, 10.0);
        for (int i = 0; i < poses.size(); ++i) {
            const std::vector<double> excess = limits.excess(poses.poses[std::size_t(i)].parent_from_joint);
            for (std::size_t j = 0; j < excess.size(); ++j) {
                INFO(file.path << ", frame " << poses.frame_idx[std::size_t(i)] << ", "
                               << standard_skeleton().joint_names[j]);
                // The ankle bends further under the body's weight than in the hands of an examiner, and by how much an
                // arm may turn depends on where it points.
                CHECK(excess[j] < 18 * degree);
                num_outside += excess[j] > 2 * degree ? 1 : 0;
                ++num_checked;
            }
        }
    }
    CHECK(num_outside < 0.005 * num_checked);
}

TEST_CASE("the walk is symmetric and its feet alternate on the ground; the squat is deep on flat feet")
{
    const Points rest = human_joints();
    const KeyframeMotion walk = read_keyframe_motion(config_path("motions/walk.json"));
    const PoseSet steps = keyframe_poses(walk, rest, 0.0);
    const Skeleton& skeleton = standard_skeleton();
    const int left = skeleton.joint("left_foot"), right = skeleton.joint("right_foot");
    double step_length = 0;
    for (const Pose& pose : steps.poses) {
        const Points posed = posed_joints(rest, pose);
        CHECK(std::min(posed(left, 1), posed(right, 1)) < 0.14);
        step_length = std::max(step_length, std::abs(posed(left, 2) - posed(right, 2)));
    }
    CHECK(step_length > 0.45);
    CHECK(step_length < 0.85);

    // Half a period later the body is its own mirror image.
    for (double t = 0; t < walk.period; t += 0.03) {
        const std::vector<double> now = walk.angles(t), later = walk.angles(t + 0.5 * walk.period);
        for (std::size_t k = 0; k < now.size(); ++k) {
            const std::string& name = clinical_angle_names()[k];
            INFO(name << " at " << t);
            const std::string other = name.rfind("left_", 0) == 0 ? "right_" + name.substr(5) : name;
            const bool sideways = other == name && name.find("_left") != std::string::npos;
            if (name.rfind("right_", 0) == 0) continue;
            CHECK(now[k] == Approx((sideways ? -1 : 1) * later[std::size_t(find_clinical_angle(other))]).margin(1e-9));
        }
    }

    const PoseSet squat = keyframe_poses(read_keyframe_motion(config_path("motions/squat.json")), rest, 0.0);
    double lowest = 1e9, tilt = 0;
    for (const Pose& pose : squat.poses) {
        const auto motion = forward_kinematics(skeleton, rest, pose);
        lowest = std::min(lowest, (motion[0] * rest.row(0).transpose().eval()).y());
        for (const int foot : {left, right}) {
            tilt = std::max(tilt, std::acos(std::min(1.0, (motion[foot].linear() * Eigen::Vector3d::UnitY()).y())));
        }
        const Eigen::RowVector3d ankles =
            0.5 * (posed_joints(rest, pose).row(left) + posed_joints(rest, pose).row(right));
        CHECK(ankles.z() == Approx(0.5 * (rest(left, 2) + rest(right, 2))).margin(1e-9));
    }
    CHECK(lowest < 0.45 * rest(0, 1));
    CHECK(tilt < 12 * degree);
}

TEST_CASE("motions in which flesh swings are within human ranges, and their flights are free falls")
{
    const Points rest = human_joints();
    const JointLimits limits(read_joint_limits(config_path("joint-limits.json")), rest);
    int num_motions = 0, num_flights = 0;
    for (const MotionFile& file : find_motion_files({config_path("dynamic-motions")})) {
        INFO(file.path);
        REQUIRE(file.keyframes);
        const KeyframeMotion motion = read_keyframe_motion(file.path);
        CHECK(motion.duration >= 1.5);
        for (const Pose& pose : keyframe_poses(motion, rest, 20.0).poses) {
            for (const double excess : limits.excess(pose.parent_from_joint)) CHECK(excess < 18 * degree);
        }
        KeyframeMotion grounded = motion;
        grounded.lift = {};
        const PoseSet high = keyframe_poses(motion, rest, 0.0), low = keyframe_poses(grounded, rest, 0.0);
        for (int f = 0; f < high.size(); ++f) {
            const Eigen::Vector3d raised =
                high.poses[std::size_t(f)].root_translation - low.poses[std::size_t(f)].root_translation;
            const Eigen::Vector3d expected(0, motion.height(f / motion.frame_rate), 0);
            CHECK((raised - expected).norm() < 1e-12);
        }
        ++num_motions;
        if (motion.lift.times.empty()) continue;
        // From the top to the ground in the time that falling takes.
        double top = 0, top_time = 0;
        for (double t = 0; t < motion.period; t += 1e-3) {
            if (motion.height(t) <= top) continue;
            top = motion.height(t);
            top_time = t;
        }
        double end = top_time;
        while (motion.height(end) > 1e-9) end += 1e-3;
        CHECK(end - top_time == Approx(std::sqrt(2 * top / 9.81)).epsilon(0.1));
        ++num_flights;
    }
    CHECK(num_motions == 5);
    CHECK(num_flights == 3);
}
