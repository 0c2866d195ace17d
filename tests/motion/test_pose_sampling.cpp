// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/core/threads.h"
#include "ndg/geometry/rotation.h"
#include "ndg/motion/pose_sampling.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

using namespace ndg;
using Catch::Matchers::Contains;

namespace {

constexpr int num_joints = 12;

/// Clusters of similar poses, as motion has: the pruning must not skip what matters. Joint 3 never moves.
std::vector<Pose> random_poses(int count, std::uint64_t seed)
{
    std::vector<Pose> poses;
    for (int i = 0; i < count; ++i) {
        Random near(seed, "near", i), far(seed, "far", i / 10);
        Pose pose = Pose::rest(num_joints);
        for (int j = 0; j < num_joints; ++j) {
            const Eigen::Vector3d axis(far.normal(), far.normal(), far.normal());
            const Eigen::Vector3d jitter(near.normal(), near.normal(), near.normal());
            if (j == 3) continue;
            pose.parent_from_joint[j] = (Eigen::AngleAxisd(far.uniform(0, M_PI), axis.normalized()) *
                                         Eigen::AngleAxisd(near.uniform(0, 0.2), jitter.normalized()))
                                            .toRotationMatrix();
        }
        poses.push_back(pose);
    }
    return poses;
}

/// Sum of angles from the trace, another formula than the library's.
double reference_distance(const Pose& a, const Pose& b)
{
    double sum = 0.0;
    for (int j = 0; j < num_joints; ++j) {
        const double trace = (a.parent_from_joint[j].transpose() * b.parent_from_joint[j]).trace();
        sum += std::acos(std::clamp(0.5 * (trace - 1.0), -1.0, 1.0));
    }
    return sum;
}

/// Every pick updates every distance, all of them as pose_distance sums them.
PoseSampling brute_force(const std::vector<Pose>& poses, int count, int first_idx)
{
    std::vector<Eigen::Quaterniond> joints;
    for (const Pose& pose : poses) {
        for (const Eigen::Matrix3d& rotation : pose.parent_from_joint) joints.push_back(to_quaternion(rotation));
    }
    PoseSampling sampling;
    std::vector<double> nearest(poses.size(), 1e300);
    for (int next = first_idx; static_cast<int>(sampling.order.size()) < count;) {
        sampling.order.push_back(next);
        for (std::size_t i = 0; i < poses.size(); ++i) {
            double sum = 0.0;
            for (int j = 0; j < num_joints; ++j) {
                sum += rotation_angle(joints[i * num_joints + j], joints[next * num_joints + j]);
            }
            nearest[i] = std::min(nearest[i], sum);
        }
        const auto farthest = std::max_element(nearest.begin(), nearest.end());
        sampling.covering_radius.push_back(*farthest);
        next = static_cast<int>(farthest - nearest.begin());
    }
    return sampling;
}

PoseSampling sampling_with_threads(int threads, const std::vector<Pose>& poses, int count, int first)
{
    const int before = num_threads();
    set_num_threads(threads);
    PoseSampling sampling = farthest_point_sampling(poses, count, {first});
    set_num_threads(before);
    return sampling;
}

}  // namespace

TEST_CASE("rotation angles are exact for small, large and antipodal rotations")
{
    const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 3).normalized();
    for (const double angle : {0.0, 1e-12, 1e-7, 1e-3, 0.5, 2.0, 3.0, M_PI - 1e-9, M_PI}) {
        const Eigen::Quaterniond base(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitY()));
        Eigen::Quaterniond turned = base * Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis));
        CHECK(rotation_angle(base, turned) == Approx(angle).margin(2e-15));
        turned.coeffs() *= -1.0;
        CHECK(rotation_angle(base, turned) == Approx(angle).margin(2e-15));
        CHECK(rotation_angle(base.toRotationMatrix(), turned.toRotationMatrix()) == Approx(angle).margin(1e-14));
    }
}

TEST_CASE("twist and minimal rotation")
{
    const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, -1).normalized();
    const Eigen::Vector3d swing_axis = axis.cross(Eigen::Vector3d::UnitX()).normalized();
    for (const double twist : {-2.5, -0.4, 0.0, 0.9, 3.0}) {
        const Eigen::Matrix3d rotation =
            (Eigen::AngleAxisd(0.8, swing_axis) * Eigen::AngleAxisd(twist, axis)).toRotationMatrix();
        CHECK(twist_angle(rotation, axis) == Approx(twist).margin(1e-13));
    }
    const Eigen::Vector3d from(0.3, -2, 1);
    for (const Eigen::Vector3d& to :
         {Eigen::Vector3d(1, 1, 1), from, Eigen::Vector3d(-from), Eigen::Vector3d(0, 0, 5)}) {
        const Eigen::Matrix3d rotation = minimal_rotation(from, to);
        CHECK((rotation * from.normalized() - to.normalized()).norm() < 1e-12);
        CHECK(rotation.determinant() == Approx(1.0));
        CHECK((rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).norm() < 1e-12);
        const double angle = std::acos(std::clamp(from.normalized().dot(to.normalized()), -1.0, 1.0));
        CHECK(rotation_angle(rotation, Eigen::Matrix3d::Identity()) == Approx(angle).margin(1e-7));
    }
}

TEST_CASE("pose distance is the sum of joint angles and a metric")
{
    const std::vector<Pose> poses = random_poses(40, 3);
    for (int i = 0; i < 40; i += 3) {
        for (int k = 0; k < 40; k += 7) {
            CHECK(pose_distance(poses[i], poses[k]) == Approx(reference_distance(poses[i], poses[k])).margin(1e-6));
            CHECK(pose_distance(poses[i], poses[k]) == Approx(pose_distance(poses[k], poses[i])).margin(1e-13));
            CHECK(pose_distance(poses[i], poses[k]) <=
                  pose_distance(poses[i], poses[17]) + pose_distance(poses[17], poses[k]) + 1e-12);
        }
        CHECK(pose_distance(poses[i], poses[i]) == 0.0);
    }
    Pose bent = Pose::rest(num_joints);
    bent.parent_from_joint[2] = Eigen::AngleAxisd(0.25, Eigen::Vector3d::UnitX()).toRotationMatrix();
    bent.parent_from_joint[5] = Eigen::AngleAxisd(1.5, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    CHECK(pose_distance(Pose::rest(num_joints), bent) == Approx(1.75));
}

TEST_CASE("farthest-point sampling equals brute force")
{
    const std::vector<Pose> poses = random_poses(500, 11);
    constexpr int count = 120;
    const PoseSampling sampling = farthest_point_sampling(poses, count, {42});
    REQUIRE(sampling.order.size() == count);
    REQUIRE(sampling.covering_radius.size() == count);
    std::vector<int> order = {42};
    for (int pick = 0; pick < count; ++pick) {
        // From scratch for every pick: distance of each pose to all picked ones.
        int farthest = 0;
        double radius = -1.0;
        for (int i = 0; i < 500; ++i) {
            double nearest = 1e300;
            for (const int k : order) nearest = std::min(nearest, reference_distance(poses[i], poses[k]));
            if (nearest > radius) {
                radius = nearest;
                farthest = i;
            }
        }
        REQUIRE(sampling.order[pick] == order.back());
        CHECK(sampling.covering_radius[pick] == Approx(radius).margin(1e-6));
        if (pick > 0) CHECK(sampling.covering_radius[pick] <= sampling.covering_radius[pick - 1]);
        order.push_back(farthest);
    }
}

TEST_CASE("sampling all poses takes each once and covers them; threads do not matter")
{
    const std::vector<Pose> poses = random_poses(200, 5);
    const PoseSampling one = sampling_with_threads(1, poses, 200, 0), four = sampling_with_threads(4, poses, 200, 0);
    CHECK(one.order == four.order);
    CHECK(one.covering_radius == four.covering_radius);
    CHECK(one.covering_radius.back() == 0.0);
    std::vector<int> sorted = one.order;
    std::sort(sorted.begin(), sorted.end());
    for (int i = 0; i < 200; ++i) CHECK(sorted[i] == i);
}

TEST_CASE("sampling is the same to the last bit as brute force, ties and all")
{
    std::vector<Pose> poses = random_poses(2003, 21);
    // The same pose twice: a tie at any time, which the lower index wins.
    for (int i = 0; i < 100; ++i) poses[1500 + i] = poses[3 * i];
    CHECK(pose_distance(poses[5], poses[1900]) == brute_force({poses[5], poses[1900]}, 1, 0).covering_radius.front());
    // The last count is all that differ.
    for (const int count : {7, 500, 1903}) {
        const PoseSampling expected = brute_force(poses, count, 1777);
        const PoseSampling sampling = farthest_point_sampling(poses, count, {1777});
        CHECK(sampling.order == expected.order);
        CHECK(sampling.covering_radius == expected.covering_radius);
    }
}

TEST_CASE("sampling so many poses that threads share them gives the same on one and two, and as brute force")
{
    const std::vector<Pose> poses = random_poses(12003, 31);
    const PoseSampling one = sampling_with_threads(1, poses, 200, 12002);
    const PoseSampling two = sampling_with_threads(2, poses, 200, 12002);
    CHECK(one.order == two.order);
    CHECK(one.covering_radius == two.covering_radius);
    const PoseSampling expected = brute_force(poses, 20, 12002);
    CHECK(std::equal(expected.order.begin(), expected.order.end(), two.order.begin()));
    CHECK(std::equal(expected.covering_radius.begin(), expected.covering_radius.end(), two.covering_radius.begin()));
}

TEST_CASE("sampling refuses wrong counts and equal poses")
{
    std::vector<Pose> poses = random_poses(10, 7);
    CHECK_THROWS_AS(farthest_point_sampling(poses, 0, {0}), InputError);
    CHECK_THROWS_WITH(farthest_point_sampling(poses, 11, {0}), Contains("11 poses were asked for, there are 10"));
    CHECK_THROWS_AS(farthest_point_sampling(poses, 5, {10}), InputError);
    CHECK_THROWS_AS(farthest_point_sampling(poses, 5, {-1}), InputError);
    CHECK_THROWS_AS(farthest_point_sampling({}, 1, {0}), InputError);
    for (int i = 3; i < 10; ++i) poses[i] = poses[0];
    CHECK(farthest_point_sampling(poses, 3, {0}).covering_radius.back() == 0.0);
    CHECK_THROWS_WITH(farthest_point_sampling(poses, 4, {0}), Contains("only 3 of the 10 differ"));
}

TEST_CASE("removing the root leaves body poses that differ by the root alone equal")
{
    std::vector<Pose> poses = random_poses(2, 9);
    Pose moved = poses[0];
    moved.parent_from_joint[0] = Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitY()).toRotationMatrix();
    moved.root_translation << 1, 2, 3;
    CHECK(pose_distance(moved, poses[0]) > 0.1);
    remove_root_motion(moved);
    remove_root_motion(poses[0]);
    CHECK(pose_distance(moved, poses[0]) == 0.0);
    CHECK(moved.root_translation.norm() == 0.0);
}

TEST_CASE("sampling goes on from poses picked before; joints that are not marked do not count")
{
    const std::vector<Pose> poses = random_poses(300, 8);
    const PoseSampling whole = farthest_point_sampling(poses, 60, {5});
    const PoseSampling rest =
        farthest_point_sampling(poses, 60, std::vector<int>(whole.order.begin(), whole.order.begin() + 20));
    CHECK(rest.order == whole.order);
    CHECK(rest.covering_radius == whole.covering_radius);
    CHECK_THROWS_AS(farthest_point_sampling(poses, 2, {1, 2, 3}), InputError);
    CHECK_THROWS_AS(farthest_point_sampling(poses, 2, std::vector<int>{}), InputError);

    std::vector<int> marked(num_joints, 0);
    marked[2] = marked[7] = 1;
    const std::vector<Pose> few = with_marked_joints(poses, marked);
    const auto angle = [&](int joint) {
        return rotation_angle(poses[4].parent_from_joint[joint], poses[250].parent_from_joint[joint]);
    };
    CHECK(pose_distance(few[4], few[250]) == Approx(angle(0) + angle(2) + angle(7)).margin(1e-12));
    CHECK_THROWS_AS(with_marked_joints(poses, {1, 1}), InputError);
}
