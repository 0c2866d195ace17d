// SPDX-License-Identifier: Apache-2.0
// Real captures: anatomy must come out right. Skipped without data.
#include "ndg/core/error.h"
#include "ndg/motion/motion_files.h"
#include "ndg/retarget/retarget.h"
#include "support/support.h"

#include "motion/human.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

using namespace ndg;
using namespace ndg::test;
using Catch::Matchers::Contains;

namespace {

struct Import {
    PoseSet poses;
    RetargetReport report;
};

Import import_file(const std::string& path, double frame_rate)
{
    const MotionClip clip = read_motion(find_motion_files({path}).at(0));
    const std::vector<JointMap> all = read_joint_maps(config_path("joint-maps"));
    const std::optional<JointMap> map = find_joint_map(all, clip);
    REQUIRE(map);
    RetargetOptions options;
    options.frame_rate = frame_rate;
    Import result;
    result.poses = retarget_clip(clip, *map, human_joints(), options, result.report);
    return result;
}

/// Flexion of the knee in degrees, positive when the shin goes back relative to the thigh's own front.
double knee_flexion(const Pose& pose, const Points& posed, const std::string& side)
{
    const auto motions = forward_kinematics(standard_skeleton(), human_joints(), pose);
    const Eigen::Vector3d thigh = at(posed, side + "shin") - at(posed, side + "thigh");
    const Eigen::Vector3d shin = at(posed, side + "foot") - at(posed, side + "shin");
    const Eigen::Vector3d front =
        motions[standard_skeleton().joint(side + "thigh")].linear() * Eigen::Vector3d::UnitZ();
    const double angle = std::atan2(thigh.cross(shin).norm(), thigh.dot(shin)) / degree;
    return shin.dot(front) - thigh.dot(front) * shin.norm() / thigh.norm() <= 0 ? angle : -angle;
}

double median(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

}  // namespace

TEST_CASE("a captured walk keeps its anatomy", "[data]")
{
    const std::string data = test::data_folder();
    if (data.empty()) return;
    const Points rest = human_joints();
    const auto& skeleton = standard_skeleton();
    for (const std::string file : {"cmu_asfamc/02/02_01.amc", "cmu_bvh/02_01.bvh", "cmu_bvh/07_01.bvh"}) {
        INFO(file);
        const Import import = import_file(data + "/motion/" + file, 30.0);
        REQUIRE(import.poses.size() > 70);
        CHECK(import.report.num_dropped_glitches <= 1);
        CHECK(import.report.num_dropped_angles == 0);
        CHECK(import.report.mean_direction_error < 1.0 * degree);
        CHECK(import.report.mean_error < 0.003);
        double low = 1e9, high = -1e9, largest_knee = 0, least_knee = 180, forward = 0;
        std::vector<double> sole_tilt, left_foot_ahead;
        for (const Pose& pose : import.poses.poses) {
            const Points posed = posed_joints(rest, pose);
            const auto motions = forward_kinematics(skeleton, rest, pose);
            const Eigen::Matrix3d pelvis = motions[0].linear();
            CHECK(at(posed, "head").y() > at(posed, "pelvis").y() + 0.4);
            CHECK(at(posed, "left_foot").y() < at(posed, "pelvis").y() - 0.5);
            CHECK(at(posed, "right_foot").y() < at(posed, "pelvis").y() - 0.5);
            CHECK(at(posed, "left_hand").y() < at(posed, "left_upper_arm").y());
            CHECK((pelvis * Eigen::Vector3d::UnitY()).y() > 0.9);
            // The left side is on the left of the walker.
            const Eigen::Vector3d left = pelvis * Eigen::Vector3d::UnitX();
            CHECK((at(posed, "left_hand") - at(posed, "right_hand")).dot(left) > 0.1);
            CHECK((at(posed, "left_foot") - at(posed, "right_foot")).dot(left) > -0.05);
            for (const std::string side : {"left_", "right_"}) {
                const double flexion = knee_flexion(pose, posed, side);
                largest_knee = std::max(largest_knee, flexion);
                least_knee = std::min(least_knee, flexion);
                const double toes = at(posed, side + "toes").y();
                low = std::min(low, toes);
                const int foot = skeleton.joint(side + "foot");
                const Eigen::Vector3d sole = motions[foot].linear() * Eigen::Vector3d::UnitY();
                const double ankle = at(posed, side + "foot").y();
                if (toes < 0.07 && ankle < 0.12) sole_tilt.push_back(std::acos(std::min(1.0, sole.y())) / degree);
            }
            high = std::max(high, at(posed, "head").y());
            const Eigen::Vector3d front = pelvis * Eigen::Vector3d::UnitZ();
            left_foot_ahead.push_back((at(posed, "left_foot") - at(posed, "right_foot")).dot(front));
        }
        const Eigen::Vector3d travel =
            import.poses.poses.back().root_translation - import.poses.poses.front().root_translation;
        const auto first = forward_kinematics(skeleton, rest, import.poses.poses.front());
        forward = travel.dot(first[0].linear() * Eigen::Vector3d::UnitZ());
        CHECK(forward > 2.0);  // walks where it faces
        CHECK(largest_knee > 45.0);
        CHECK(largest_knee < 90.0);
        CHECK(least_knee > -5.0);  // knees bend one way
        CHECK(low > -0.05);        // toes stay on the floor
        CHECK(low < 0.05);
        CHECK(high < 1.75);
        CHECK(*std::max_element(left_foot_ahead.begin(), left_foot_ahead.end()) > 0.2);
        CHECK(*std::min_element(left_foot_ahead.begin(), left_foot_ahead.end()) < -0.2);
        REQUIRE(sole_tilt.size() > 20);
        CHECK(median(sole_tilt) < 12.0);
    }
}

TEST_CASE("the artificial T pose of the BVH conversion comes out symmetric", "[data]")
{
    const std::string data = test::data_folder();
    if (data.empty()) return;
    const MotionClip clip = read_bvh(data + "/motion/cmu_bvh/02_01.bvh");
    const std::vector<JointMap> all = read_joint_maps(config_path("joint-maps"));
    JointMap map = find_joint_map(all, clip).value();
    CHECK(map.skip_first_frames == 1);
    map.skip_first_frames = 0;
    RetargetReport report;
    RetargetOptions options;
    options.frame_rate = 0.0;
    options.max_joint_speed = 1e9;
    const Points rest = human_joints();
    const PoseSet poses = retarget_clip(clip, map, rest, options, report);
    const Points posed = posed_joints(rest, poses.poses[0]);
    const Eigen::Vector3d left = at(posed, "left_hand") - at(posed, "left_upper_arm");
    const Eigen::Vector3d right = at(posed, "right_hand") - at(posed, "right_upper_arm");
    // The conversion lowers the arms of its T pose by 8 degrees.
    CHECK(std::asin(left.y() / left.norm()) / degree == Approx(-8.0).margin(0.1));
    CHECK(std::asin(right.y() / right.norm()) / degree == Approx(-8.0).margin(0.1));
    CHECK(left.x() > 0.4);
    CHECK((Eigen::Vector3d(-left.x(), left.y(), left.z()) - right).norm() < 0.02);
    const Eigen::Vector3d leg = at(posed, "left_foot") - at(posed, "left_thigh");
    CHECK(std::atan2(std::hypot(leg.x(), leg.z()), -leg.y()) / degree < 2.0);
}

TEST_CASE("every kind of captured skeleton finds its joint map and stands upright", "[data]")
{
    const std::string data = test::data_folder();
    if (data.empty()) return;
    const Points rest = human_joints();
    for (const std::string file :
         {"cmu_bvh/jumping_jacks.bvh", "cmu_daz_bvh/salsa_29.bvh", "cmu_bvh/49_04.bvh",
          "cmu_asfamc/rmocap/charleston1.amc", "hdm05_bk_asfamc/HDM_bk_squat1Reps_014_120.amc"}) {
        INFO(file);
        const Import import = import_file(data + "/motion/" + file, 10.0);
        REQUIRE(import.poses.size() > 10);
        CHECK(import.report.mean_direction_error < 1.0 * degree);
        CHECK(import.report.mean_error < 0.003);
        double lowest = 1e9;
        std::vector<double> head, knees;
        for (const Pose& pose : import.poses.poses) {
            const Points posed = posed_joints(rest, pose);
            head.push_back(at(posed, "head").y());
            knees.push_back(knee_flexion(pose, posed, "left_"));
            lowest = std::min({lowest, at(posed, "left_toes").y(), at(posed, "right_toes").y()});
        }
        CHECK(median(head) > 1.1);
        CHECK(*std::min_element(knees.begin(), knees.end()) > -12.0);
        CHECK(std::abs(lowest) < 0.15);
    }
}

TEST_CASE("motion files are found and told apart", "[data]")
{
    const test::TemporaryFolder folder;
    namespace fs = std::filesystem;
    fs::create_directories(folder.file("a"));
    fs::create_directories(folder.file("b"));
    for (const char* name : {"a/x.bvh", "a/y.AMC", "a/only.asf", "b/z.amc", "b/z.asf", "b/other.asf", "b/notes.txt"}) {
        std::ofstream(folder.file(name)) << "x";
    }
    const std::vector<MotionFile> files = find_motion_files({folder.path()});
    REQUIRE(files.size() == 4);
    CHECK(files[0].path == folder.file("a/x.bvh"));
    CHECK(files[0].skeleton_path.empty());
    CHECK(files[1].skeleton_path == folder.file("a/only.asf"));
    CHECK(files[2].path == folder.file("b/notes.txt"));
    CHECK(files[2].skip_reason == "not a BVH, AMC, DeepMimic, AMASS or keyframe motion");
    CHECK(files[3].skeleton_path == folder.file("b/z.asf"));
    CHECK_THROWS_WITH(find_motion_files({folder.file("b/notes.txt")}), Contains("notes.txt"));
    CHECK_THROWS_WITH(find_motion_files({folder.file("c")}), Contains("does not exist"));
    fs::remove(folder.file("a/only.asf"));
    const std::string why = "y.AMC: there is no .asf";
    CHECK_THAT(find_motion_files({folder.path()})[1].error, Contains(why));
    CHECK_THROWS_WITH(find_motion_files({folder.file("a/y.AMC")}), Contains(why));
    std::ofstream(folder.file("a/one.asf")) << "x";
    std::ofstream(folder.file("a/two.asf")) << "x";
    CHECK_THAT(find_motion_files({folder.path()})[1].error, Contains("begins like none of the 2 .asf"));
}

TEST_CASE("clips take as much of their path as tells them apart")
{
    ClipNames names;
    CHECK(names.add("a/s1/walk.bvh") == "walk");
    CHECK(names.add("a/s2/walk.bvh") == "s2/walk");
    CHECK(names.add("b/s2/walk.bvh") == "b/s2/walk");
    CHECK(names.add("a/s1/run.bvh") == "run");
    CHECK(names.add("/walk.bvh") == "walk.bvh");
    CHECK(names.add("/walk.bvh") == "walk.bvh 2");
}
