// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/core/threads.h"
#include "ndg/motion/pose_splicing.h"

#include "human.h"

#include <catch2/catch.hpp>

#include <set>

using namespace ndg;
using namespace ndg::test;

namespace {

/// A doll: rings of eight vertices at a known radius about each limb and along both sides of the trunk, a ball as head.
Template doll()
{
    Template result;
    result.skeleton = standard_skeleton();
    result.rest.joint_positions = human_joints();
    std::vector<Eigen::RowVector3d> points;
    std::vector<int> joints;
    const auto at = [&](const std::string& name) -> Eigen::Vector3d {
        return result.rest.joint_positions.row(result.skeleton.joint(name)).transpose();
    };
    const auto tube = [&](const std::string& joint, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                          double radius) {
        const Eigen::Vector3d axis = (to - from).normalized();
        const Eigen::Vector3d u = axis.unitOrthogonal(), v = axis.cross(u);
        for (int ring = 0; ring < 7; ++ring)
            for (int k = 0; k < 8; ++k) {
                const double angle = 0.25 * M_PI * k;
                points.push_back(
                    (from + (ring + 0.5) / 7 * (to - from) + radius * (std::cos(angle) * u + std::sin(angle) * v))
                        .transpose());
                joints.push_back(result.skeleton.joint(joint));
            }
    };
    tube("spine_3", at("pelvis"), at("neck_1"), 0.09);
    tube("head", at("head"), at("head") + Eigen::Vector3d(0, 0.2, 0), 0.08);
    for (const std::string side : {"left_", "right_"}) {
        tube("spine_2", at(side + "thigh"), at(side + "upper_arm"), 0.09);
        tube(side + "forearm", at(side + "forearm"), at(side + "hand"), 0.035);
        tube(side + "hand", at(side + "hand"), at(side + "middle_2"), 0.02);
        tube(side + "thigh", at(side + "thigh"), at(side + "shin"), 0.07);
        tube(side + "shin", at(side + "shin"), at(side + "foot"), 0.05);
    }
    const auto count = static_cast<Eigen::Index>(points.size());
    result.rest.skin_vertices.resize(count, 3);
    RowMatrix dense = RowMatrix::Zero(count, result.skeleton.num_joints());
    for (Eigen::Index v = 0; v < count; ++v) {
        result.rest.skin_vertices.row(v) = points[v];
        dense(v, joints[v]) = 1.0;
    }
    result.skin_weights = sparsify_weights(dense);
    return result;
}

void turn(Pose& pose, const std::string& joint, double angle, const Eigen::Vector3d& axis)
{
    pose.parent_from_joint[standard_skeleton().joint(joint)] = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

std::vector<Pose> random_poses(int count)
{
    std::vector<Pose> poses;
    for (int i = 0; i < count; ++i) {
        Random random(4, "test poses", i);
        Pose pose = Pose::rest(num_standard_joints);
        for (int j = 1; j < num_standard_joints; ++j) {
            const Eigen::Vector3d axis(random.normal(), random.normal(), random.normal());
            pose.parent_from_joint[j] = Eigen::AngleAxisd(random.uniform(0, 0.5), axis.normalized()).toRotationMatrix();
        }
        poses.push_back(pose);
    }
    return poses;
}

}  // namespace

TEST_CASE("capsules tell how deep an arm lies in the trunk, and see nothing where limbs are apart")
{
    const Template body = doll();
    const LimbCapsules capsules(body);
    CHECK(capsules.overlap(Pose::rest(num_standard_joints)) == 0.0);

    // The left forearm turned straight at the middle of the trunk: its axis meets that of the trunk.
    Pose through = Pose::rest(num_standard_joints);
    const Points& joints = body.rest.joint_positions;
    const auto at = [&](const char* name) -> Eigen::Vector3d {
        return joints.row(body.skeleton.joint(name)).transpose();
    };
    const Eigen::Vector3d arm = (at("left_hand") - at("left_forearm")).normalized();
    const Eigen::Vector3d target = 0.5 * (at("pelvis") + at("neck_1")) - at("left_forearm");
    through.parent_from_joint[body.skeleton.joint("left_forearm")] =
        Eigen::Quaterniond::FromTwoVectors(arm, target).toRotationMatrix();
    // Radii of forearm and trunk are known; the distance of the forearm's axis to the nearest one of the trunk's, by
    // points along both.
    const Points posed = posed_joints(joints, through);
    const auto along = [&](const char* from, const char* to, double t) -> Eigen::RowVector3d {
        const int a = body.skeleton.joint(from), b = body.skeleton.joint(to);
        return (1 - t) * posed.row(a) + t * posed.row(b);
    };
    double distance = 1.0;
    for (const auto& [from, to] : {std::pair<const char*, const char*>{"pelvis", "neck_1"},
                                   {"left_thigh", "left_upper_arm"},
                                   {"right_thigh", "right_upper_arm"}})
        for (double t = 0; t <= 1.0; t += 0.005)
            for (double u = 0; u <= 1.0; u += 0.005)
                distance = std::min(distance, (along("left_forearm", "left_hand", t) - along(from, to, u)).norm());
    CHECK(capsules.overlap(through) == Approx(0.035 + 0.09 - distance).margin(0.004));
    CHECK(capsules.overlap(through) > 0.1);

    // Its mirror image is as deep.
    Pose mirrored = Pose::rest(num_standard_joints);
    const auto flip = [](const Eigen::Vector3d& v) { return Eigen::Vector3d(-v.x(), v.y(), v.z()); };
    mirrored.parent_from_joint[body.skeleton.joint("right_forearm")] =
        Eigen::Quaterniond::FromTwoVectors(flip(arm), flip(target)).toRotationMatrix();
    CHECK(capsules.overlap(mirrored) == Approx(capsules.overlap(through)).margin(1e-6));

    // Knees through the chest: the trunk bent forward over thighs that are lifted.
    Pose folded = Pose::rest(num_standard_joints);
    turn(folded, "left_thigh", -2.6, Eigen::Vector3d::UnitX());
    CHECK(capsules.overlap(folded) > 0.04);
    turn(folded, "left_thigh", -1.2, Eigen::Vector3d::UnitX());
    CHECK(capsules.overlap(folded) == 0.0);
}

TEST_CASE("spliced poses are put together of three, limbs apart, the same on any number of threads")
{
    const Template body = doll();
    std::vector<Pose> poses = random_poses(20);
    turn(poses[3], "left_thigh", -1.4, Eigen::Vector3d::UnitX());
    turn(poses[5], "left_upper_arm", -0.9, Eigen::Vector3d::UnitZ());
    const int threads = num_threads();
    set_num_threads(1);
    const SplicedPoses spliced = splice_poses(poses, body, 300, 9);
    set_num_threads(2);
    const SplicedPoses again = splice_poses(poses, body, 300, 9), other = splice_poses(poses, body, 300, 10);
    set_num_threads(threads);
    CHECK(spliced.sources == again.sources);
    CHECK(spliced.sources != other.sources);

    const LimbCapsules capsules(body);
    std::set<std::array<int, 3>> kinds;
    for (std::size_t i = 0; i < spliced.poses.size(); ++i) {
        const auto& sources = spliced.sources[i];
        kinds.insert(sources);
        for (int j = 0; j < num_standard_joints; ++j) {
            const std::string& name = body.skeleton.joint_names[j];
            const bool side = name.rfind("left_", 0) == 0 || name.rfind("right_", 0) == 0;
            int part = 0;
            if (side && name.find("eye") == std::string::npos) part = 1;
            for (const char* leg : {"thigh", "shin", "foot", "toes"})
                if (name.find(leg) != std::string::npos) part = 2;
            REQUIRE(spliced.poses[i].parent_from_joint[j] == poses[sources[part]].parent_from_joint[j]);
        }
        double allowed = 0.01;
        for (const int source : sources) allowed = std::max(allowed, capsules.overlap(poses[source]));
        CHECK(capsules.overlap(spliced.poses[i]) <= allowed);
    }
    CHECK(kinds.size() > 250);
}

TEST_CASE("what cannot be spliced is refused")
{
    const Template body = doll();
    CHECK_THROWS_AS(splice_poses({Pose::rest(num_standard_joints)}, body, 1, 1), InputError);
    // Legs that fit none of the trunks: the trunk is bent over in one pose, a knee lifted in the other.
    std::vector<Pose> poses(2, Pose::rest(num_standard_joints));
    turn(poses[0], "spine_1", 1.6, Eigen::Vector3d::UnitX());
    turn(poses[1], "left_thigh", -1.8, Eigen::Vector3d::UnitX());
    turn(poses[1], "right_thigh", -1.8, Eigen::Vector3d::UnitX());
    const SplicedPoses spliced = splice_poses(poses, body, 40, 1);
    for (const auto& sources : spliced.sources) CHECK_FALSE((sources[0] == 0 && sources[2] == 1));
}
