// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/anatomy.h"
#include "ndg/bones/bone_rig.h"
#include "ndg/core/error.h"
#include "ndg/geometry/rotation.h"
#include "support/support.h"

#include <catch2/catch.hpp>

using namespace ndg;

namespace {

double largest(const Points& a, const Points& b)
{
    return (a - b).rowwise().norm().maxCoeff();
}

/// Two points on segment 0 and 1, one half-way.
BoneWeights two_segments()
{
    return {{0, 1, 2, 4}, {0, 1, 0, 1}, {1, 1, 0.5, 0.5}};
}

}  // namespace

TEST_CASE("Dual quaternions move what belongs to one bone exactly and what lies between by the turn half-way")
{
    Points rest(3, 3);
    rest << 0, 0, 0.1, 0, 1, 0.1, 0.1, 0.5, 0;
    const Eigen::Vector3d joint(0, 0.5, 0);
    const Eigen::Isometry3d still = Eigen::Isometry3d::Identity(), turned = Eigen::Translation3d(joint) *
                                                                            Eigen::Isometry3d(about_z(2.0)) *
                                                                            Eigen::Translation3d(-joint);
    for (const Eigen::Isometry3d& carried : {still, Eigen::Translation3d(1, 2, 3) * Eigen::Isometry3d(about_y(3.0))}) {
        const Points posed = dual_quaternion_blending(rest, two_segments(), {carried, carried * turned});
        CHECK((posed.row(0).transpose() - carried * rest.row(0).transpose()).norm() < 1e-12);
        CHECK((posed.row(1).transpose() - carried * turned * rest.row(1).transpose()).norm() < 1e-12);
        const Eigen::Vector3d half = joint + about_z(1.0) * (rest.row(2).transpose() - joint);
        CHECK((posed.row(2).transpose() - carried * half).norm() < 1e-12);  // no collapse towards the joint
    }
    CHECK_THROWS_AS(dual_quaternion_blending(rest.topRows(2), two_segments(), {still, turned}), Error);
}

TEST_CASE("A bone that no rule names moves as the best rigid fit of its skinning")
{
    const Template tube = test::tube_template();
    const RiggedBodies rigged(tube);
    REQUIRE(rigged.rig().list.num_segments == 1);
    const Points anatomy = anatomy_at_rest(tube, tube.rest);
    for (const double bend : {0.0, 0.9}) {
        const auto joints = forward_kinematics(tube.skeleton, tube.rest.joint_positions, test::tube_pose(bend));
        const auto segments = rigged.of(tube.rest)->motion.segments(joints);
        const BoneList::Bone& bone = rigged.rig().list.bones.front();
        Points blended = linear_blend_skinning(anatomy, tube.anatomy_weights, joints), moved = blended;
        move_bones(rigged.rig().list, anatomy, segments, moved);
        const auto rows = [&](const Points& points) -> Points {
            return points.middleRows(bone.vertex_begin, bone.vertex_end - bone.vertex_begin);
        };
        if (bend == 0.0) CHECK(largest(rows(moved), rows(anatomy)) < 1e-12);
        // No small rigid motion brings it nearer.
        const double distance = (rows(moved) - rows(blended)).squaredNorm();
        for (int axis = 0; axis < 3; ++axis) {
            std::vector<Eigen::Isometry3d> other = segments;
            other[0].pretranslate(1e-4 * Eigen::Vector3d::Unit(axis));
            Points again = blended;
            move_bones(rigged.rig().list, anatomy, other, again);
            CHECK((rows(again) - rows(blended)).squaredNorm() > distance);
            other = segments;
            const Eigen::Vector3d mean = rows(moved).colwise().mean();
            other[0] = Eigen::Translation3d(mean) * Eigen::Isometry3d(rotation_of(1e-3 * Eigen::Vector3d::Unit(axis))) *
                       Eigen::Translation3d(-mean) * segments[0];
            move_bones(rigged.rig().list, anatomy, other, again);
            CHECK((rows(again) - rows(blended)).squaredNorm() > distance - 1e-12);
        }
    }
    // The same rig while body and joints are the same, another one for another body.
    Body other = tube.rest;
    other.joint_positions.col(1).array() += 0.01;
    CHECK(rigged.of(tube.rest) == rigged.of(tube.rest));
    CHECK(rigged.of(other) != rigged.of(tube.rest));
}

TEST_CASE("A template without bones has none to keep rigid")
{
    Template tube = test::tube_template();
    for (AnatomyPart& part : tube.anatomy_parts) part.layer = AnatomyLayer::muscle;
    CHECK_THROWS_AS(RiggedBodies(tube), InputError);
}

TEST_CASE("Spread weights stay weights and grow no new bones far away")
{
    const Template tube = test::tube_template(21, 12);
    const int num_wrap = tube.num_wrap_vertices();
    BoneWeights sharp{{0}, {}, {}};
    const Points wrap = tube.rest.volume_vertices.topRows(num_wrap);
    const double middle = 0.5 * (wrap.col(1).minCoeff() + wrap.col(1).maxCoeff());
    for (int v = 0; v < num_wrap; ++v) {
        sharp.segments.push_back(wrap(v, 1) < middle ? 0 : 1);
        sharp.weights.push_back(1.0);
        sharp.begins.push_back(v + 1);
    }
    const BoneWeights smooth = smoothed_weights(sharp, wrap, tube.wrap_triangles, 0.05);
    int shared = 0;
    for (int v = 0; v < num_wrap; ++v) {
        double sum = 0;
        for (int k = smooth.begins[v]; k < smooth.begins[v + 1]; ++k) sum += smooth.weights[k];
        CHECK(sum == Approx(1));
        const bool is_shared = smooth.begins[v + 1] - smooth.begins[v] == 2;
        shared += is_shared;
        if (std::abs(wrap(v, 1) - middle) > 0.3) CHECK(!is_shared);
    }
    CHECK(shared > 2 * 12);
}

TEST_CASE("Weights are spread along the surface by the asked standard deviation")
{
    constexpr int rings = 85, segments = 16;  // edges as long along the tube as around it
    constexpr double spread = 0.05;
    const Template tube = test::tube_template(rings, segments);
    const int num_wrap = tube.num_wrap_vertices();
    const Points wrap = tube.rest.volume_vertices.topRows(num_wrap);
    BoneWeights sharp{{0}, {}, {}};
    for (int v = 0; v < num_wrap; ++v) {
        sharp.segments.push_back(v / segments < rings / 2 ? 0 : 1);
        sharp.weights.push_back(1.0);
        sharp.begins.push_back(v + 1);
    }
    const BoneWeights smooth = smoothed_weights(sharp, wrap, tube.wrap_triangles, spread);
    // A step spread by a distribution rises as that does: the variance of its rise is the distribution's.
    std::vector<double> second(rings, 0.0);
    for (int ring = 0; ring < rings; ++ring) {
        const int v = ring * segments;
        for (int k = smooth.begins[v]; k < smooth.begins[v + 1]; ++k)
            if (smooth.segments[k] == 1) second[ring] = smooth.weights[k];
    }
    double rise = 0, mean = 0, square = 0;
    for (int ring = 1; ring < rings; ++ring) {
        const double step = second[ring] - second[ring - 1],
                     y = 0.5 * (wrap(ring * segments, 1) + wrap((ring - 1) * segments, 1));
        rise += step;
        mean += step * y;
        square += step * y * y;
    }
    CHECK(rise == Approx(1));
    CHECK(std::sqrt(square - mean * mean) == Approx(spread).epsilon(0.1));
}
