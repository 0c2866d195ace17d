// SPDX-License-Identifier: Apache-2.0
#include "ndg/bones/spine.h"
#include "ndg/bones/thorax.h"
#include "ndg/geometry/rotation.h"

#include <catch2/catch.hpp>

using namespace ndg;

namespace {

constexpr double level_height = 0.025;

/// A straight spine along y at z = -0.02 whose joints lie on it at the levels where BodyParts3D's are.
struct Column {
    Points joints = Points::Zero(num_standard_joints, 3), levels{num_spine_levels, 3}, centres{num_vertebrae, 3};
    Column()
    {
        for (int i = 0; i < num_spine_levels; ++i) levels.row(i) << 0, 1 + level_height * i, -0.02;
        for (int i = 0; i < num_vertebrae; ++i) centres.row(i) << 0, 1 + level_height * (i + 0.5), -0.02;
        const std::vector<std::pair<const char*, int>> at = {{"spine_1", 1}, {"spine_2", 3},  {"spine_3", 5},
                                                             {"spine_4", 8}, {"spine_5", 10}, {"neck_1", 17},
                                                             {"neck_2", 20}, {"head", 24}};
        for (const auto& [name, level] : at) joints.row(standard_skeleton().joint(name)) = levels.row(level);
        joints.row(0) << 0, 0.95, 0;
    }
    std::vector<Eigen::Isometry3d> posed(const std::vector<std::pair<std::string, Eigen::Matrix3d>>& turns) const
    {
        Pose pose = Pose::rest(num_standard_joints);
        for (const auto& [name, turn] : turns) pose.parent_from_joint[standard_skeleton().joint(name)] = turn;
        return forward_kinematics(standard_skeleton(), joints, pose);
    }
};

double distance(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b)
{
    return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("A joint's turn is shared by the levels about it and adds up to it")
{
    const Column column;
    const SpineMotion spine(column.joints, column.levels, column.centres);
    for (int axis = 0; axis < 3; ++axis)
        for (int k = 0; k < 8; ++k) {
            double sum = 0, place = 0;
            for (int i = 0; i < num_spine_levels; ++i) {
                CHECK(spine.share(k, i, axis) >= 0);
                sum += spine.share(k, i, axis);
                place += spine.share(k, i, axis) * i;
            }
            CHECK(sum == Approx(1));
            const int level[] = {1, 3, 5, 8, 10, 17, 20, 24};
            if (k < 7 && axis != 1) CHECK(place == Approx(level[k]).margin(1e-6));  // balanced about the joint
        }
    // spine_2 reaches from spine_1 to spine_3 and no farther.
    CHECK(spine.share(1, 1, 0) == 0);
    CHECK(spine.share(1, 2, 0) > 0.1);
    CHECK(spine.share(1, 5, 0) == 0);
    // The head turns between axis and atlas, not between atlas and skull.
    CHECK(spine.share(7, 23, 1) > 4 * spine.share(7, 24, 1));
}

TEST_CASE("Vertebrae stand still at rest, turn more from level to level, and follow the skeleton")
{
    const Column column;
    const SpineMotion spine(column.joints, column.levels, column.centres);
    for (const Eigen::Isometry3d& motion : spine.vertebrae(column.posed({})))
        CHECK(distance(motion, Eigen::Isometry3d::Identity()) < 1e-12);

    const double bend = 0.35;
    const auto joints = column.posed({{"spine_1", about_x(bend)},
                                      {"spine_2", about_x(bend)},
                                      {"spine_3", about_x(bend)},
                                      {"spine_4", about_x(bend)},
                                      {"spine_5", about_y(bend)}});
    const auto vertebrae = spine.vertebrae(joints);
    CHECK(rotation_angle(vertebrae[0].linear(), Eigen::Matrix3d::Identity()) < bend);
    CHECK(rotation_angle(vertebrae[16].linear(), joints[standard_skeleton().joint("spine_5")].linear()) < 1e-9);
    double previous = 0;
    for (int i = 0; i < 8; ++i) {
        const double angle = rotation_angle(vertebrae[std::size_t(i)].linear(), Eigen::Matrix3d::Identity());
        CHECK(angle >= previous);
        previous = angle;
    }
    for (int i = 0; i < num_vertebrae; ++i) {
        const Eigen::Vector3d level = column.levels.row(i).transpose();
        const Eigen::Isometry3d& below = i == 0 ? joints[0] : vertebrae[std::size_t(i) - 1];
        CHECK((below * level - vertebrae[std::size_t(i)] * level).norm() < 0.003);
    }
    // Half-way between two joints a vertebra is where the skeleton has it.
    const Eigen::Vector3d centre = column.centres.row(14).transpose();
    CHECK((vertebrae[14] * centre - joints[standard_skeleton().joint("spine_5")] * centre).norm() < 0.002);
}

TEST_CASE("Ribs keep their heads on the vertebrae and point to where the sternum goes")
{
    Strut rib{{0.02, 1.3, -0.05}, {0.05, 1.2, 0.1}, 1.0};
    Eigen::Isometry3d vertebra = Eigen::Isometry3d::Identity(), sternum = Eigen::Isometry3d::Identity();
    sternum.translation() << 0, 0.02, 0;
    const Eigen::Isometry3d motion = strut_motion(rib, vertebra, sternum);
    CHECK((motion * rib.first - rib.first).norm() < 1e-12);
    const Eigen::Vector3d wanted = sternum * rib.second - rib.first, got = motion * rib.second - rib.first;
    CHECK(got.normalized().dot(wanted.normalized()) == Approx(1));
    CHECK(got.norm() == Approx((rib.second - rib.first).norm()));
    rib.second_share = sternum_share(12);
    CHECK(distance(strut_motion(rib, vertebra, sternum), vertebra) < 1e-12);
    CHECK(sternum_share(7) == 1);
    CHECK(sternum_share(9) == Approx(0.5));
}
