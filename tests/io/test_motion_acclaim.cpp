// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/io/motion.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <fstream>
#include <map>

using namespace ndg;
using Catch::Matchers::Contains;

namespace {

const std::string asf = R"(# comment
:version 1.10
:name VICON
:units
  mass 1.0
  length 0.45
  angle deg
:documentation
   anything at all
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 0 0
   orientation 0 0 0
:bonedata
  begin
     id 1
     name upper
     direction 1 0 0
     length 2
     axis 0 0 90 XYZ
    dof rx rz
    limits (-160.0 20.0)
           (-70.0 70.0)
  end
  begin
     id 2
     name lower
     direction 0 0 3
     length 1.5
     axis 0 0 0 XYZ
  end
:hierarchy
  begin
    root upper
    upper lower
  end
)";
const std::string amc =
    "#!OML:ASF f\xfcr\n:FULLY-SPECIFIED\n:DEGREES\n1\nroot 1 2 3 10 20 30\nupper 40 50\n2\nroot 4 5 6 0 0 0\nupper 0 "
    "0\n";

struct Files {
    test::TemporaryFolder folder;
    MotionClip read(const std::string& skeleton, const std::string& frames) const
    {
        std::ofstream(folder.file("s.asf"), std::ios::binary) << skeleton;
        std::ofstream(folder.file("take.amc"), std::ios::binary) << frames;
        return read_asf_amc(folder.file("s.asf"), folder.file("take.amc"));
    }
};

std::string replaced(std::string text, const std::string& what, const std::string& by)
{
    const std::size_t at = text.find(what);
    REQUIRE(at != std::string::npos);
    return text.replace(at, what.size(), by);
}

Eigen::Matrix3d turn(const Eigen::Vector3d& axis, double degrees)
{
    return Eigen::AngleAxisd(degrees * M_PI / 180, axis).toRotationMatrix();
}

/// Names of the same joints in cgspeed's BVH conversion and in the ASF.
const std::map<std::string, std::string> asf_of_bvh = {{"Hips", "root"},
                                                       {"LHipJoint", "lhipjoint"},
                                                       {"LeftUpLeg", "lfemur"},
                                                       {"LeftLeg", "ltibia"},
                                                       {"LeftFoot", "lfoot"},
                                                       {"LeftToeBase", "ltoes"},
                                                       {"RHipJoint", "rhipjoint"},
                                                       {"RightUpLeg", "rfemur"},
                                                       {"RightLeg", "rtibia"},
                                                       {"RightFoot", "rfoot"},
                                                       {"RightToeBase", "rtoes"},
                                                       {"LowerBack", "lowerback"},
                                                       {"Spine", "upperback"},
                                                       {"Spine1", "thorax"},
                                                       {"Neck", "lowerneck"},
                                                       {"Neck1", "upperneck"},
                                                       {"Head", "head"},
                                                       {"LeftShoulder", "lclavicle"},
                                                       {"LeftArm", "lhumerus"},
                                                       {"LeftForeArm", "lradius"},
                                                       {"LeftHand", "lwrist"},
                                                       {"LeftFingerBase", "lhand"},
                                                       {"LeftHandIndex1", "lfingers"},
                                                       {"LThumb", "lthumb"},
                                                       {"RightShoulder", "rclavicle"},
                                                       {"RightArm", "rhumerus"},
                                                       {"RightForeArm", "rradius"},
                                                       {"RightHand", "rwrist"},
                                                       {"RightFingerBase", "rhand"},
                                                       {"RightHandIndex1", "rfingers"},
                                                       {"RThumb", "rthumb"}};

}  // namespace

TEST_CASE("ASF and AMC are read with axis frames, units and order")
{
    const Files files;
    const MotionClip clip = files.read(asf, amc);
    CHECK(clip.name == "take");
    CHECK(clip.joint_names == std::vector<std::string>{"root", "upper", "lower"});
    CHECK(clip.parents == std::vector<int>{-1, 0, 1});
    CHECK(clip.frame_rate == 120.0);
    CHECK(clip.frame_rate_assumed);
    CHECK(clip.metres_per_unit == Approx(0.0564444).epsilon(1e-5));
    CHECK(clip.zero_pose_positions.row(1).norm() == 0.0);
    CHECK((clip.zero_pose_positions.row(2) - Eigen::RowVector3d(2, 0, 0)).norm() < 1e-15);
    CHECK((clip.zero_pose_tips.row(2) - Eigen::RowVector3d(2, 0, 1.5)).norm() < 1e-15);
    REQUIRE(clip.num_frames() == 2);

    const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
    const Eigen::Matrix3d root = turn(z, 30) * turn(y, 20) * turn(x, 10);
    // The bone's axis frame is turned by 90 degrees about z: its x is the world's y.
    const Eigen::Matrix3d upper = root * turn(z, 50) * turn(y, 40);
    CHECK((clip.world_from_joint[0][0] - root).norm() < 1e-14);
    CHECK((clip.world_from_joint[0][1] - upper).norm() < 1e-14);
    CHECK((clip.world_from_joint[0][2] - upper).norm() < 1e-14);
    CHECK((clip.root_positions.row(0) - Eigen::RowVector3d(1, 2, 3)).norm() == 0.0);
    CHECK((clip.joint_positions(0).row(2).transpose() - Eigen::Vector3d(1, 2, 3) - upper * Eigen::Vector3d(2, 0, 0))
              .norm() < 1e-14);
    CHECK((clip.world_from_joint[1][1] - Eigen::Matrix3d::Identity()).norm() < 1e-15);
}

TEST_CASE("radians and another root order mean the same motion")
{
    const Files files;
    const MotionClip expected = files.read(asf, amc);
    const std::string order = replaced(asf, "TX TY TZ RX RY RZ", "RZ RY RX TZ TY TX");
    const MotionClip clip = files.read(order, replaced(amc, "root 1 2 3 10 20 30", "root 30 20 10 3 2 1"));
    CHECK((clip.world_from_joint[0][1] - expected.world_from_joint[0][1]).norm() < 1e-14);
    CHECK((clip.root_positions.row(0) - expected.root_positions.row(0)).norm() == 0.0);
    const std::string radians = replaced(replaced(amc, ":DEGREES", ":RADIANS"), "10 20 30\nupper 40 50",
                                         "0.17453292519943295 0.3490658503988659 0.5235987755982988\nupper "
                                         "0.6981317007977318 0.8726646259971648");
    CHECK((files.read(asf, radians).world_from_joint[0][1] - expected.world_from_joint[0][1]).norm() < 1e-14);
}

TEST_CASE("malformed ASF and AMC files are refused with file, line and value")
{
    const Files files;
    const auto check = [&](const std::string& skeleton, const std::string& frames, const std::string& message) {
        CHECK_THROWS_AS(files.read(skeleton, frames), InputError);
        CHECK_THROWS_WITH(files.read(skeleton, frames), Contains(files.folder.path()) && Contains(message));
    };
    check(asf, replaced(amc, "upper 40 50", "upper 40"), "bone 'upper' has 1 values in frame 1, the skeleton has 2");
    check(asf, replaced(amc, "upper 40 50", "tail 40 50"), "take.amc: line 6: unknown bone 'tail'");
    check(asf, replaced(amc, "upper 40 50", "upper 40 nan"), "value 1 of bone 'upper' in frame 1 is 'nan'");
    check(asf, replaced(amc, "upper 40 50\n", ""), "frame 1 lacks bone 'upper'");
    check(asf, replaced(amc, "upper 0 0\n", ""), "frame 2 lacks bone 'upper'");
    check(asf, replaced(amc, "\n2\n", "\n3\n"), "frame 3 follows frame 1");
    check(asf, replaced(amc, "upper 40 50", "upper 40 50\nupper 40 50"), "bone 'upper' stands twice in frame 1");
    check(asf, ":FULLY-SPECIFIED\n:DEGREES\n", "0 frames");
    check(asf, "", "is empty");
    check(asf, "upper 1 2\n", "stands before the first frame");
    check(replaced(asf, "dof rx rz", "dof rx l"), amc, "degree of freedom 'l' of bone 'upper'");
    check(replaced(asf, "upper lower", "upper tail"), amc, "s.asf: line 36: unknown bone 'tail' in :hierarchy");
    check(replaced(asf, "    upper lower\n", ""), amc, "bone 'lower' is not connected to the root");
    check(replaced(asf, "length 1.5", "size 1.5"), amc, "unknown keyword 'size' in bone 'lower'");
    check(replaced(asf, "direction 0 0 3", "direction 0 0 0"), amc, "direction of bone 'lower' is zero");
    check(replaced(asf, "axis 0 0 90 XYZ", "axis 0 0 90 XYY"), amc, "axis order 'XYY'");
    check(replaced(asf, "angle deg", "angle grad"), amc, "unknown angle unit 'grad'");
    check(asf.substr(0, 400), amc, "the file ends inside bone 'lower'");
    CHECK_THROWS_WITH(read_asf_amc(files.folder.file("none.asf"), files.folder.file("take.amc")),
                      Contains("none.asf: does not exist"));
}

TEST_CASE("the same take as ASF/AMC and as BVH gives the same motion", "[data]")
{
    const std::string data = test::data_folder();
    if (data.empty()) return;
    for (const auto& [subject, take] : std::map<std::string, std::string>{{"02", "02_01"}, {"05", "05_13"}}) {
        INFO(take);
        const std::string folder = data + "/motion/cmu_asfamc/" + subject + "/";
        const MotionClip acclaim = read_asf_amc(folder + subject + ".asf", folder + take + ".amc");
        const MotionClip bvh = read_bvh(data + "/motion/cmu_bvh/" + take + ".bvh");
        REQUIRE(acclaim.num_joints() == 31);
        REQUIRE(bvh.num_joints() == 31);
        REQUIRE(bvh.num_frames() == acclaim.num_frames() + 1);  // the conversion puts a T pose in front
        double largest_angle = 0.0, largest_distance = 0.0;
        for (int f = 0; f < acclaim.num_frames(); f += 7) {
            const Points ours = acclaim.joint_positions(f);
            const Points theirs = bvh.joint_positions(f + 1);
            for (int b = 0; b < bvh.num_joints(); ++b) {
                const std::string& name = asf_of_bvh.at(bvh.joint_names[b]);
                const int a = acclaim.find_joint(name);
                const Eigen::Matrix3d difference =
                    bvh.world_from_joint[f + 1][b].transpose() * acclaim.world_from_joint[f][a];
                largest_angle = std::max(largest_angle, (difference - Eigen::Matrix3d::Identity()).norm());
                // The conversion lost the lengths of thorax and wrist bones: add them back above the thorax, and again
                // beyond the wrists.
                Eigen::Vector3d lost = Eigen::Vector3d::Zero();
                for (int j = acclaim.parents[a]; j >= 0; j = acclaim.parents[j]) {
                    const std::string& above = acclaim.joint_names[j];
                    if (above != "thorax" && above != "lwrist" && above != "rwrist") continue;
                    lost += acclaim.world_from_joint[f][j] *
                            (acclaim.zero_pose_tips.row(j) - acclaim.zero_pose_positions.row(j)).transpose();
                }
                largest_distance = std::max(largest_distance, (theirs.row(b) + lost.transpose() - ours.row(a)).norm());
            }
        }
        CHECK(largest_angle < 2e-5);     // the BVH has four decimals of a degree
        CHECK(largest_distance < 2e-4);  // file units of 5.6 cm
    }
}

TEST_CASE("an AMC says its rate, an ASF names its skins")
{
    const Files files;
    const auto read = [&](const std::string& skeleton, const std::string& motion) {
        std::ofstream(files.folder.file("s.asf")) << skeleton;
        std::ofstream(files.folder.file("take.amc")) << motion;
        return read_asf_amc(files.folder.file("s.asf"), files.folder.file("take.amc"));
    };
    MotionClip clip = read(asf, amc);
    CHECK(clip.frame_rate == 120.0);
    CHECK(clip.frame_rate_assumed);
    for (const std::string line : {":SAMPLES-PER-SECOND 60", ":samples-per-second\t60.0"}) {
        clip = read(asf + ":skin\n body.obj\n\n another one.obj\n", replaced(amc, ":DEGREES", line + "\n:DEGREES"));
        CHECK(clip.frame_rate == 60.0);
        CHECK_FALSE(clip.frame_rate_assumed);
        CHECK(clip.num_frames() == 2);
        CHECK(clip.num_joints() == 3);
    }
    for (const std::string line : {":SAMPLES-PER-SECOND", ":SAMPLES-PER-SECOND 0", ":SAMPLES-PER-SECOND often"})
        CHECK_THROWS_AS(read(asf, replaced(amc, ":DEGREES", line + "\n:DEGREES")), InputError);
    CHECK_THROWS_WITH(read(replaced(asf, ":hierarchy", ":hair"), amc), Contains("unknown section ':hair'"));
}
