// SPDX-License-Identifier: Apache-2.0
#include "ndg/bones/bone_rig.h"
#include "ndg/core/threads.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/rotation.h"
#include "support/support.h"

#include <catch2/catch.hpp>

using namespace ndg;

namespace {

/// The same bone twice, as two segments that every vertex of the wrap belongs to.
struct TwoBones {
    explicit TwoBones(const Template& tube) : list(tube)
    {
        list.bones.push_back(list.bones.front());
        list.bones.back().segment = 1;
        list.num_segments = 2;
        for (int v = 0; v < tube.num_wrap_vertices(); ++v) {
            halves.segments.insert(halves.segments.end(), {0, 1});
            halves.weights.insert(halves.weights.end(), {0.5, 0.5});
            halves.begins.push_back(2 * (v + 1));
        }
    }

    BoneList list;
    BoneWeights halves{{0}, {}, {}};
};

}  // namespace

TEST_CASE("The wrap at rest stays, and gives way outwards to a bone that comes through")
{
    const Template tube = test::tube_template(21, 16);
    const Points wrap = tube.rest.volume_vertices.topRows(tube.num_wrap_vertices());
    const TwoBones two(tube);
    const WrapPeaks peaks(two.list, tube, two.halves);
    const BoneClearance clearance(peaks, tube.anatomy_vertices, wrap);

    std::vector<Eigen::Isometry3d> motions(2, Eigen::Isometry3d::Identity());
    Points posed = wrap;
    clearance.push_out(motions, posed);
    CHECK((posed - wrap).cwiseAbs().maxCoeff() == 0);

    // The second bone goes sideways until it stands out of the wrap by `out`.
    const auto bone = tube.anatomy_vertices.topRows(tube.anatomy_parts.front().vertex_end);
    const double bone_radius = bone.col(0).maxCoeff(), wrap_radius = wrap.col(0).maxCoeff();
    const double out = 0.003;
    motions[1].translation().x() = wrap_radius - bone_radius + out;
    clearance.push_out(motions, posed);
    const double height = 0.5 * (wrap.col(1).minCoeff() + wrap.col(1).maxCoeff());
    double farthest = 0;
    for (Eigen::Index v = 0; v < wrap.rows(); ++v) {
        if (std::abs(wrap(v, 1) - height) < 0.1) farthest = std::max(farthest, posed(v, 0));
        CHECK(posed(v, 0) >= wrap(v, 0) - 1e-9 - (wrap(v, 0) < 0 ? 0.02 : 0));  // outwards
    }
    CHECK(farthest > wrap_radius + out);
    CHECK(farthest < wrap_radius + out + 0.02);

    // So also where it slid along the wrap to places that were over other parts of it.
    posed = wrap;
    motions[1].translation().y() = 0.12;
    clearance.push_out(motions, posed);
    for (const int threads : {1, 3}) {
        const int before = num_threads();
        set_num_threads(threads);
        Points again = wrap;
        clearance.push_out(motions, again);
        set_num_threads(before);
        CHECK(again == posed);
    }
    const TriangleTree tree(posed, tube.wrap_triangles);
    for (Eigen::Index v = 0; v < bone.rows(); ++v) {
        const Eigen::Vector3d point = motions[1] * bone.row(v).transpose();
        if (std::abs(point.y() - height) < 0.2) CHECK(tree.signed_distance(point) < 0.001);
    }
}

TEST_CASE("A thin bone does not come through the side of the wrap that it is farther from at rest")
{
    Template tube = test::tube_template(21, 16);
    const int num_wrap = tube.num_wrap_vertices(), num_bone = tube.anatomy_parts.front().vertex_end;
    // A flat wrap, 12 mm to both sides, and in it a plate of 2 mm nearer to the one side.
    auto wrap_rows = tube.rest.volume_vertices.topRows(num_wrap);
    wrap_rows.col(0) *= 0.012 / wrap_rows.col(0).maxCoeff();
    auto bone = tube.anatomy_vertices.topRows(num_bone);
    bone.col(0) *= 0.001 / bone.col(0).maxCoeff();
    bone.col(0).array() += 0.004;
    const Points wrap = wrap_rows;
    const TwoBones two(tube);
    const WrapPeaks peaks(two.list, tube, two.halves);
    const BoneClearance clearance(peaks, tube.anatomy_vertices, wrap);

    std::vector<Eigen::Isometry3d> motions(2, Eigen::Isometry3d::Identity());
    motions[1].translation().x() = -0.018;  // out by 3 mm on the other side
    Points posed = wrap;
    clearance.push_out(motions, posed);
    const TriangleTree tree(posed, tube.wrap_triangles);
    const double height = 0.5 * (wrap.col(1).minCoeff() + wrap.col(1).maxCoeff());
    for (int v = 0; v < num_bone; ++v) {
        const Eigen::Vector3d point = motions[1] * bone.row(v).transpose();
        if (std::abs(point.y() - height) < 0.2) CHECK(tree.signed_distance(point) < 0.001);
    }
}

TEST_CASE("A bent wrap out of which a bone comes is as it was when these figures were stored")
{
    const Template tube = test::tube_template(21, 16);
    const int num_wrap = tube.num_wrap_vertices();
    const Points wrap = tube.rest.volume_vertices.topRows(num_wrap);
    TwoBones two(tube);
    const int half_way = two.list.bones.front().vertex_end / 2;
    two.list.bones.front().vertex_end = two.list.bones.back().vertex_begin = half_way;
    const double middle = 0.5 * (wrap.col(1).minCoeff() + wrap.col(1).maxCoeff());
    BoneWeights sharp{{0}, {}, {}};
    for (int v = 0; v < num_wrap; ++v) {
        sharp.segments.push_back(wrap(v, 1) < middle ? 0 : 1);
        sharp.weights.push_back(1.0);
        sharp.begins.push_back(v + 1);
    }
    const BoneWeights weights = smoothed_weights(sharp, wrap, tube.wrap_triangles, 0.05);
    const WrapPeaks peaks(two.list, tube, weights);
    const BoneClearance clearance(peaks, tube.anatomy_vertices, wrap);
    // The upper half of the bone bends by 30 degrees, turns by 30 and stands out of the wrap of its lower end.
    const double bone_radius = tube.anatomy_vertices.topRows(half_way).col(0).maxCoeff();
    std::vector<Eigen::Isometry3d> motions(2, Eigen::Isometry3d::Identity());
    motions[1] = Eigen::Translation3d(2 * (wrap.col(0).maxCoeff() - bone_radius) + 0.006, middle, 0) *
                 Eigen::Isometry3d(about_z(M_PI / 6) * about_y(M_PI / 6)) * Eigen::Translation3d(0, -middle, 0);
    const Points blended = dual_quaternion_blending(wrap, weights, motions);
    Points posed = blended;
    clearance.push_out(motions, posed);
    const auto volume = [&](const Points& x) {  // over the origin
        double sum = 0;
        for (Eigen::Index t = 0; t < tube.wrap_triangles.rows(); ++t) {
            const auto corner = [&](int k) -> Eigen::Vector3d { return x.row(tube.wrap_triangles(t, k)); };
            sum += corner(0).cross(corner(1)).dot(corner(2)) / 6;
        }
        return 1e6 * sum;  // ml
    };
    const auto pushed = (posed - blended).rowwise().norm();
    Eigen::Index farthest = 0;
    const double most = 1000 * pushed.maxCoeff(&farthest);
    CHECK(volume(blended) == Approx(1878.618).margin(0.001));
    CHECK(volume(posed) == Approx(1915.28).margin(0.05));
    CHECK(most == Approx(12.876).margin(0.01));  // mm
    CHECK(farthest == 184);
    CHECK(1000 * pushed.sum() == Approx(113.37).margin(0.2));
    const Eigen::RowVector3d beside(-0.00723, 0.48467, 0.01051), end(-0.188184, 0.942144, -0.023801);
    CHECK((posed.row(num_wrap / 2) - beside).norm() < 2e-5);
    CHECK((posed.row(num_wrap - 1) - end).norm() < 1e-6);
}
