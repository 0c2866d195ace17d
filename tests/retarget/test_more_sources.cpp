// SPDX-License-Identifier: Apache-2.0
// DeepMimic and AMASS motions on our skeleton.
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/io/smpl_skeleton.h"
#include "ndg/motion/motion_files.h"
#include "ndg/retarget/retarget.h"
#include "support/support.h"

#include "io/smpl_model.h"
#include "motion/human.h"

#include <catch2/catch.hpp>

#include <array>
#include <cmath>
#include <filesystem>
#include <iostream>

using namespace ndg;
using namespace ndg::test;
using Catch::Matchers::Contains;

namespace {

PoseSet every_frame(const MotionClip& clip)
{
    const std::vector<JointMap> all = read_joint_maps(config_path("joint-maps"));
    const std::optional<JointMap> map = find_joint_map(all, clip);
    REQUIRE(map);
    RetargetOptions options;
    options.frame_rate = 0.0;
    options.max_joint_speed = 1e9;
    options.inverse_kinematics = false;
    RetargetReport report;
    const PoseSet poses = retarget_clip(clip, *map, human_joints(), options, report);
    CHECK(report.mean_direction_error < 1e-6);
    return poses;
}

}  // namespace

TEST_CASE("DeepMimic and AMASS files are found beside what they need")
{
    const test::TemporaryFolder folder;
    const std::string clip = "{\n\"Loop\": \"none\",\n\"Frames\": []}";
    for (const char* name : {"a/h_character.json", "a/h_walk.txt", "a/notes.txt", "a/settings.json", "b/alone.txt"}) {
        std::filesystem::create_directories(std::filesystem::path(folder.file(name)).parent_path());
        const std::string text = name;
        write_file(folder.file(name), text == "a/h_walk.txt" || text == "b/alone.txt" ? clip : "{\"a\": 1}");
    }
    const std::vector<MotionFile> files = find_motion_files({folder.file("a")});
    REQUIRE(files.size() == 3);
    CHECK(files[0].path == folder.file("a/h_walk.txt"));
    CHECK(files[0].skeleton_path == folder.file("a/h_character.json"));
    CHECK(files[0].skip_reason.empty());
    CHECK(files[1].skip_reason == "not a BVH, AMC, DeepMimic, AMASS or keyframe motion");
    CHECK(files[2].path == folder.file("a/settings.json"));
    CHECK_FALSE(files[2].skip_reason.empty());
    CHECK_THROWS_WITH(find_motion_files({folder.file("b/alone.txt")}),
                      Contains("alone.txt: there is no *_character.json skeleton beside it"));
    CHECK_THROWS_WITH(find_motion_files({folder.file("a/h_character.json")}), Contains("not a BVH"));
    write_file(folder.file("b/x.npz"), "x");
    CHECK_THROWS_WITH(find_motion_files({folder.file("b/x.npz")}), Contains("x.npz: is no zip archive"));
}

TEST_CASE("every DeepMimic clip stands upright facing +z with hanging arms at the zero pose", "[data]")
{
    const std::string data = test::data_folder();
    if (data.empty()) return;
    int num_clips = 0;
    for (const MotionFile& file : find_motion_files({data + "/motion/deepmimic"})) {
        INFO(file.path);
        REQUIRE(file.skip_reason.empty());
        MotionClip clip = read_motion(file);
        ++num_clips;
        REQUIRE(clip.num_joints() == 15);
        CHECK(clip.frame_rate > 15.0);
        CHECK(clip.frame_rate < 61.0);
        // The zero pose of the file itself, as one frame.
        MotionClip zero = clip;
        zero.world_from_joint = {std::vector<Eigen::Matrix3d>(15, Eigen::Matrix3d::Identity())};
        zero.root_positions = Points::Zero(1, 3);
        const auto source = [&](const char* joint) {
            return Eigen::Vector3d(clip.zero_pose_positions.row(clip.find_joint(joint)).transpose());
        };
        CHECK(source("left_hip").x() > 0.05);
        CHECK(source("right_hip").x() < -0.05);
        CHECK(source("left_ankle").y() < source("root").y() - 0.7);
        CHECK((source("left_wrist") - source("left_shoulder")).normalized().y() < -0.99);
        CHECK(clip.zero_pose_tips(clip.find_joint("left_ankle"), 2) > 0.02);  // feet point to +z

        const Points posed = posed_joints(human_joints(), every_frame(zero).poses.at(0));
        for (const std::string side : {"left_", "right_"}) {
            CHECK(direction(posed, side + "upper_arm", side + "forearm").y() < -0.999);
            CHECK(direction(posed, side + "forearm", side + "hand").y() < -0.999);
            CHECK(direction(posed, side + "thigh", side + "shin").y() < -0.999);
            CHECK(direction(posed, side + "shin", side + "foot").y() < -0.999);
            CHECK(direction(posed, side + "foot", side + "toes").z() > 0.8);
        }
        CHECK(direction(posed, "pelvis", "head").y() > 0.99);
        CHECK(at(posed, "left_foot").x() > 0.05);

        const PoseSet poses = every_frame(clip);
        CHECK(poses.size() == clip.num_frames());
    }
    CHECK(num_clips == 12);
}

TEST_CASE("DeepMimic's walk and run go where they face with bent knees behind", "[data]")
{
    const std::string data = test::data_folder();
    if (data.empty()) return;
    for (const std::string name : {"walk", "run"}) {
        INFO(name);
        const std::string path = data + "/motion/deepmimic/humanoid3d_" + name + ".txt";
        const MotionClip clip = read_motion(find_motion_files({path}).at(0));
        const PoseSet poses = every_frame(clip);
        double largest_bend = 0.0;
        for (const Pose& pose : poses.poses) {
            const Points posed = posed_joints(human_joints(), pose);
            const Eigen::Vector3d trunk = direction(posed, "pelvis", "head");
            CHECK(trunk.y() > 0.8);  // the runner leans forward
            CHECK(trunk.z() > -0.1);
            const Eigen::Matrix3d pelvis = pose.parent_from_joint[0];
            CHECK(pelvis(2, 2) > 0.8);
            CHECK(pelvis(1, 1) > 0.8);
            for (const std::string side : {"left_", "right_"}) {
                CHECK(at(posed, side + "foot").y() < at(posed, "pelvis").y() - 0.15);  // heels kick up
                // The shin lies behind the line of the thigh.
                const Eigen::Vector3d thigh = direction(posed, side + "thigh", side + "shin");
                const Eigen::Vector3d shin = direction(posed, side + "shin", side + "foot");
                const double bend = pelvis.col(0).dot(thigh.cross(shin));
                CHECK(bend > -0.1);
                largest_bend = std::max(largest_bend, bend);
            }
            CHECK((at(posed, "left_hand") - at(posed, "right_hand")).dot(pelvis.col(0)) > 0.1);
        }
        CHECK(largest_bend > 0.5);
        const Eigen::Vector3d travel = poses.poses.back().root_translation - poses.poses.front().root_translation;
        CHECK(travel.z() > 1.0);
        CHECK(std::abs(travel.x()) < 0.3 * travel.z());
    }
}

TEST_CASE("AMASS poses come out on our skeleton as they stand in the file")
{
    const test::TemporaryFolder folder;
    write_file(folder.file("write.py"), R"(import numpy as np
h = np.pi / 2
poses = np.zeros((2, 156))
poses[:, 0] = h                                  # stands in the z-up world, facing -y
poses[1, 3:6] = [-h, 0, 0]                       # left thigh forward
poses[1, 12:15] = [h, 0, 0]                      # left knee bent: shin down again
poses[1, 48:51] = [0, 0, -h]                     # left arm down
poses[1, 51:54] = [0, 0, h]                      # right arm down
trans = np.array([[0., 0, 0.9], [0, -1, 0.9]])   # one metre forward
np.savez('walk_poses.npz', poses=poses, trans=trans, mocap_framerate=120.)
np.savez('shape.npz', betas=np.zeros(16))
)");
    const std::string change_folder = "cd " + folder.path() + " && ";
    if (test::run_command(change_folder + "/usr/bin/python3 write.py").exit_code != 0 &&
        test::run_command(change_folder + "python3 write.py").exit_code != 0) {
        std::cout << "Skipped: no python3 with numpy (Debian: python3-numpy)" << std::endl;
        return;
    }
    const std::vector<MotionFile> files = find_motion_files({folder.path()});
    REQUIRE(files.size() == 3);
    CHECK(files[0].skip_reason == "an .npz without AMASS poses");
    CHECK(files[1].skip_reason.empty());
    CHECK_THROWS_WITH(find_motion_files({files[0].path}), Contains("shape.npz: is an .npz without AMASS poses"));

    const PoseSet poses = every_frame(read_motion(files[1]));
    REQUIRE(poses.size() == 2);
    const Points stand = posed_joints(human_joints(), poses.poses[0]);
    const Points lunge = posed_joints(human_joints(), poses.poses[1]);
    const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
    for (const double sign : {1.0, -1.0}) {
        const std::string side = sign > 0 ? "left_" : "right_";
        CHECK((direction(stand, side + "upper_arm", side + "forearm") - sign * x).norm() < 1e-6);
        CHECK((direction(stand, side + "forearm", side + "hand") - sign * x).norm() < 1e-6);
        CHECK((direction(stand, side + "thigh", side + "shin") + y).norm() < 1e-6);
        CHECK((direction(stand, side + "shin", side + "foot") + y).norm() < 1e-6);
        CHECK(direction(stand, side + "foot", side + "toes").z() > 0.8);
        CHECK((direction(lunge, side + "upper_arm", side + "forearm") + y).norm() < 1e-6);
        CHECK((direction(lunge, side + "forearm", side + "hand") + y).norm() < 1e-6);
        CHECK((direction(lunge, side + "shin", side + "foot") + y).norm() < 1e-6);
    }
    CHECK((direction(lunge, "left_thigh", "left_shin") - z).norm() < 1e-6);
    CHECK((direction(lunge, "right_thigh", "right_shin") + y).norm() < 1e-6);
    CHECK(direction(lunge, "left_foot", "left_toes").z() > 0.8);
    const Eigen::Vector3d travel = poses.poses[1].root_translation - poses.poses[0].root_translation;
    CHECK(travel.z() > 0.8);
    CHECK(std::abs(travel.x()) < 1e-9);
    CHECK(std::abs(travel.y()) < 1e-9);
}

TEST_CASE("limbs, spine and fingers of AMASS clips point as forward kinematics of the body model does")
{
    const test::TemporaryFolder folder;
    if (!test::write_smpl_model(folder)) return;
    const SmplSkeleton model(folder.file("model.npz"));
    const MotionFile file = find_motion_files({folder.file("shaped_poses.npz")}).at(0);
    const MotionClip clip = read_motion(file, &model);
    const std::vector<std::array<std::string, 4>> segments = {
        {"left_upper_arm", "left_forearm", "left_shoulder", "left_elbow"},
        {"left_forearm", "left_hand", "left_elbow", "left_wrist"},
        {"right_upper_arm", "right_forearm", "right_shoulder", "right_elbow"},
        {"right_forearm", "right_hand", "right_elbow", "right_wrist"},
        {"left_thigh", "left_shin", "left_hip", "left_knee"},
        {"left_shin", "left_foot", "left_knee", "left_ankle"},
        {"right_thigh", "right_shin", "right_hip", "right_knee"},
        {"right_shin", "right_foot", "right_knee", "right_ankle"},
        {"left_hand", "left_middle_1", "left_wrist", "left_middle1"},
        {"right_hand", "right_middle_1", "right_wrist", "right_middle1"}};
    const auto worst_error = [&](const PoseSet& poses) {
        double worst = 0.0;
        for (int f = 0; f < poses.size(); ++f) {
            const Points ours = posed_joints(human_joints(), poses.poses[f]), truth = clip.joint_positions(f);
            for (const auto& [from, to, source_from, source_to] : segments) {
                const Eigen::RowVector3d bone =
                    truth.row(clip.find_joint(source_to)) - truth.row(clip.find_joint(source_from));
                const double cosine = direction(ours, from, to).dot(bone.normalized().transpose());
                worst = std::max(worst, std::acos(std::min(cosine, 1.0)));
            }
        }
        return worst / degree;
    };
    // `clip` is right: io/test_smpl_skeleton.cpp.
    CHECK(worst_error(every_frame(clip)) < 1e-3);
    const double without_model = worst_error(every_frame(read_motion(file)));
    CHECK(without_model > 5.0);
    CHECK(without_model < 25.0);

    // Fingers turn as they do in the file: middle finger's second joint against its first.
    const PoseSet poses = every_frame(clip);
    const Skeleton& skeleton = standard_skeleton();
    for (const std::string side : {"left_", "right_"}) {
        for (const std::string finger : {"thumb", "index", "middle", "ring", "pinky"}) {
            const int ours = skeleton.joint(side + finger + "_2");
            const int joint = clip.find_joint(side + finger + "2");
            REQUIRE(ours >= 0);
            REQUIRE(joint >= 0);
            for (int f = 0; f < poses.size(); ++f) {
                const Eigen::Matrix3d local =
                    clip.world_from_joint[f][clip.parents[joint]].transpose() * clip.world_from_joint[f][joint];
                const double file_angle = Eigen::AngleAxisd(local).angle();
                CHECK(Eigen::AngleAxisd(poses.poses[f].parent_from_joint[ours]).angle() ==
                      Approx(file_angle).margin(1e-5));
            }
        }
    }
}
