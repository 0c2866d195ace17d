// SPDX-License-Identifier: Apache-2.0
// Rigs whose zero pose is no standing person, or faces elsewhere: the poses that come out are those that went in.
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/retarget/import_motions.h"
#include "ndg/retarget/joint_map_proposal.h"
#include "support/support.h"

#include "retarget/foreign_rig.h"

#include <catch2/catch.hpp>

#include <algorithm>

using namespace ndg;
using namespace ndg::test;
using Catch::Matchers::Contains;

namespace {

MotionImportOptions every_frame()
{
    MotionImportOptions options;
    options.retarget.frame_rate = 0.0;
    options.retarget.max_joint_speed = 1e9;
    return options;
}

ImportedMotions import(MotionFiles files, const MotionImportOptions& options)
{
    files.complete();
    return import_motions(files, options, human_joints(), [](const std::string&) {});
}

/// By the project's map, or by the one that is proposed for the file.
ImportedMotions import_bvh(const std::string& path, const MotionImportOptions& options, bool proposed)
{
    MotionFiles files;
    files.motions = {path};
    if (proposed) {
        const std::string map = path + ".json";
        write_file(map, joint_map_json(propose_joint_map(read_bvh(path)).map, "proposed"));
        files.joint_map = {map};
    }
    return import(files, options);
}

/// Mean angle (degrees) between the world rotations of main joints in two imports.
double mean_difference(const PoseSet& a, const PoseSet& b)
{
    REQUIRE(a.size() == b.size());
    const Skeleton& skeleton = standard_skeleton();
    double sum = 0.0;
    int count = 0;
    for (int f = 0; f < a.size(); ++f) {
        const auto x = forward_kinematics(skeleton, human_joints(), a.poses[std::size_t(f)]);
        const auto y = forward_kinematics(skeleton, human_joints(), b.poses[std::size_t(f)]);
        for (const char* joint : {"pelvis", "spine_5", "head", "left_thigh", "right_thigh", "left_shin", "right_shin",
                                  "left_foot", "right_foot", "left_upper_arm", "right_forearm", "left_hand"}) {
            const auto j = std::size_t(skeleton.joint(joint));
            sum += rotation_angle(Eigen::Matrix3d(x[j].linear()), Eigen::Matrix3d(y[j].linear()));
            ++count;
        }
    }
    return sum / count / degree;
}

double worst_degrees(const ImportedMotions& imported)
{
    REQUIRE(imported.reports.size() == 1);
    REQUIRE(imported.reports[0].worst_segment() != nullptr);
    INFO(imported.reports[0].worst_segment()->segment);
    return imported.reports[0].worst_segment()->mean / degree;
}

struct Case {
    std::string name;
    Frames frames;
    bool frame_is_reference;
    double largest_difference;  ///< degrees, mean_difference
};

std::vector<Case> zero_poses(const MotionClip& clip)
{
    const auto turn = [](const Eigen::Vector3d& axis, double degrees) {
        return Eigen::AngleAxisd(degrees * degree, axis).toRotationMatrix();
    };
    const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY();
    // The frame in which the hips are lowest.
    Eigen::Index deepest = 0;
    clip.root_positions.col(1).minCoeff(&deepest);
    return {{"bones along x", frames_along_x(clip), true, 7.0},
            {"crouched", frames_of_pose(clip.world_from_joint[std::size_t(deepest)]), true, 7.0},
            {"lying on the back", frames_turned(clip, turn(x, -90)), false, 0.5},
            {"lying on the face", frames_turned(clip, turn(x, 90)), false, 0.5},
            {"lying askew", frames_turned(clip, turn(y, 30) * turn(x, -90)), false, 0.5},
            {"facing 20 degrees off", frames_turned(clip, turn(y, 20)), false, 0.5},
            {"facing 44 degrees off", frames_turned(clip, turn(y, -44)), false, 0.5},
            {"leaning by 25 degrees", frames_turned(clip, turn(x, 25)), false, 6.0}};
}

}  // namespace

TEST_CASE("what the zero pose of a rig is does not change the poses")
{
    const test::TemporaryFolder folder;
    const std::string plain = folder.file("plain.bvh"), foreign = folder.file("foreign.bvh");
    for (const char* motion : {"squat", "walk"}) {
        const MotionClip clip = built_in_clip(motion, plain_rig(), 15.0);
        write_bvh(plain, clip, own_frames(clip));
        const ImportedMotions by_map = import_bvh(plain, every_frame(), false);
        const ImportedMotions by_proposal = import_bvh(plain, every_frame(), true);
        CHECK(by_map.reports[0].reference == "zero pose");
        CHECK(worst_degrees(by_map) < 8.0);
        CHECK(worst_degrees(by_proposal) < 8.0);
        for (const Case& zero : zero_poses(clip)) {
            for (const bool proposed : {false, true}) {
                INFO(motion << ", " << zero.name << (proposed ? ", proposed map" : ""));
                write_bvh(foreign, clip, zero.frames);
                const ImportedMotions imported = import_bvh(foreign, every_frame(), proposed);
                CHECK((imported.reports[0].reference != "zero pose") == zero.frame_is_reference);
                CHECK(worst_degrees(imported) < 9.0);
                const PoseSet& expected = proposed ? by_proposal.poses : by_map.poses;
                CHECK(mean_difference(expected, imported.poses) < zero.largest_difference);
                CHECK(imported.disagreements.empty());
                CHECK(imported.reports[0].num_poses == clip.num_frames());
            }
        }
    }
}

TEST_CASE("a disagreement with the source is seen, named, and fails the run's check")
{
    const test::TemporaryFolder folder;
    const std::string path = folder.file("foreign.bvh");
    const MotionClip clip = built_in_clip("squat", plain_rig(), 10.0);
    MotionImportOptions options = every_frame();
    options.conventions.reference_frame = zero_pose_is_reference;
    const std::vector<Case> cases = zero_poses(clip);
    for (const std::string name : {"crouched", "facing 20 degrees off", "facing 44 degrees off"}) {
        INFO(name);
        const auto zero = std::find_if(cases.begin(), cases.end(), [&](const Case& c) { return c.name == name; });
        write_bvh(path, clip, zero->frames);
        const ImportedMotions imported = import_bvh(path, options, false);
        REQUIRE(imported.disagreements.size() == 1);
        CHECK_THAT(imported.disagreements[0], Contains("foreign: ") && Contains("degrees elsewhere than the source's"));
        CHECK_THROWS_AS(imported.check(), QualityError);
        const double worst = worst_degrees(imported);
        if (name == "facing 20 degrees off") CHECK(worst == Approx(20.0).margin(4.0));
        if (name == "facing 44 degrees off") CHECK(worst == Approx(44.0).margin(4.0));
    }
    // All poses are beyond the limits of the map: which, and by how much.
    write_bvh(path, clip, cases[0].frames);
    CHECK_THROWS_WITH(import_bvh(path, options, false),
                      Contains("gave no pose; foreign: ") && Contains("degrees from rest, its limit is 80"));
}

TEST_CASE("a reference frame is taken where it is asked for, also from another file of the rig")
{
    const test::TemporaryFolder folder;
    const MotionClip stands = built_in_clip("squat", plain_rig(), 10.0);
    MotionClip crouches = stands;
    // The frames in which the knees are bent, alone.
    std::vector<int> bent;
    for (int f = 0; f < stands.num_frames(); ++f) {
        if (stands.root_positions(f, 1) < 75.0) bent.push_back(f);
    }
    REQUIRE(bent.size() > 5);
    crouches.world_from_joint.clear();
    crouches.root_positions.resize(Eigen::Index(bent.size()), 3);
    for (std::size_t k = 0; k < bent.size(); ++k) {
        crouches.world_from_joint.push_back(stands.world_from_joint[std::size_t(bent[k])]);
        crouches.root_positions.row(Eigen::Index(k)) = stands.root_positions.row(bent[k]);
    }
    const Frames frames = frames_along_x(stands);
    write_bvh(folder.file("plain.bvh"), crouches, own_frames(crouches));
    write_bvh(folder.file("crouches.bvh"), crouches, frames);
    write_bvh(folder.file("stands.bvh"), stands, frames);
    const ImportedMotions expected = import_bvh(folder.file("plain.bvh"), every_frame(), false);
    MotionFiles files;
    files.motions = {folder.file("crouches.bvh")};
    files.reference = folder.file("stands.bvh");
    MotionImportOptions options = every_frame();
    for (const int frame : {find_reference_frame, 0}) {
        options.conventions.reference_frame = frame;
        const ImportedMotions imported = import(files, options);
        CHECK_THAT(imported.reports[0].reference, Contains("of stands"));
        CHECK(mean_difference(expected.poses, imported.poses) < 4.0);
    }
    files.reference.clear();
    files.motions = {folder.file("stands.bvh")};
    CHECK(import(files, options).reports[0].reference == "frame 0");
    options.conventions.reference_frame = 100000;
    CHECK_THROWS_WITH(import(files, options), Contains("the reference frame is 100000"));
    options.conventions.reference_frame = 0;
    const MotionClip other =
        built_in_clip("squat", renamed(plain_rig(), [](const std::string& name) { return name + "X"; }));
    write_bvh(folder.file("other.bvh"), other, own_frames(other));
    files.reference = folder.file("other.bvh");
    CHECK_THROWS_WITH(import(files, options), Contains("the reference has no joint"));
}

TEST_CASE("proposals for rigs with any zero pose name the bones that the names and lengths say")
{
    const test::TemporaryFolder folder;
    const std::string path = folder.file("rig.bvh");
    for (const bool with_names : {true, false}) {
        MotionClip clip = built_in_clip("squat", plain_rig(), 10.0);
        for (const Case& zero : zero_poses(clip)) {
            MotionClip named = clip;
            if (!with_names) {
                for (int j = 0; j < clip.num_joints(); ++j) named.joint_names[std::size_t(j)] = "b" + std::to_string(j);
            }
            write_bvh(path, named, zero.frames);
            const MotionClip read = read_bvh(path);
            const JointMapProposal proposal = propose_joint_map(read);
            INFO(zero.name << (with_names ? "" : ", no names"));
            for (const RigJoint& joint : plain_rig()) {
                if (joint.ours.find("spine") != std::string::npos || joint.ours.find("neck") != std::string::npos)
                    continue;
                const JointMapEntry* entry = proposal.map.find(joint.ours);
                INFO(joint.ours);
                REQUIRE(entry != nullptr);
                const int j = clip.find_joint(joint.name);
                CHECK(entry->source == named.joint_names[std::size_t(j)]);
            }
        }
    }
}
