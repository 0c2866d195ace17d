// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/skeleton.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/makehuman/makehuman.h"
#include "support/support.h"

#include <catch2/catch.hpp>

using namespace ndg;
using Catch::Matchers::Contains;

TEST_CASE("MakeHuman's sliders do what they say", "[makehuman]")
{
    if (test::data_folder().empty()) return;
    const MakeHuman source(test::data_folder() + "/makehuman");
    const ParametricSurface middle = source.evaluate({});
    CHECK(middle.vertices.rows() == 13380);
    CHECK(middle.triangles.rows() == 26756);
    CHECK(closed_surface_defect(middle.vertices, middle.triangles).empty());
    CHECK(middle.vertices.col(1).minCoeff() == Approx(0.0).margin(1e-12));
    CHECK(stature(middle.vertices) > 1.5);
    CHECK(stature(middle.vertices) < 1.85);

    const auto with = [&](auto change) {
        MakeHumanParameters p;
        change(p);
        const ParametricSurface s = source.evaluate(p);
        return std::make_pair(stature(s.vertices), body_density * enclosed_volume(s.vertices, s.triangles));
    };
    const auto base = with([](MakeHumanParameters&) {});
    CHECK(with([](MakeHumanParameters& p) { p.height = 0.9; }).first > base.first + 0.1);
    CHECK(with([](MakeHumanParameters& p) { p.height = 0.1; }).first < base.first - 0.1);
    CHECK(with([](MakeHumanParameters& p) { p.weight = 0.9; }).second > 1.05 * base.second);
    CHECK(with([](MakeHumanParameters& p) { p.weight = 0.1; }).second < 0.95 * base.second);
    const auto heavy = with([](MakeHumanParameters& p) {
        p.weight = 0.9;
        p.muscle = 0.2;
    });
    CHECK(heavy.second > 1.25 * base.second);
    CHECK(with([](MakeHumanParameters& p) { p.sex = 1.0; }).first >
          with([](MakeHumanParameters& p) { p.sex = 0.0; }).first);
    CHECK_THROWS_WITH(with([](MakeHumanParameters& p) { p.age = 0.2; }), Contains("age is 0.2"));

    // Joints: left is +x, the hand below the shoulder in the A pose, symmetric to a centimetre.
    const Skeleton& skeleton = standard_skeleton();
    const auto at = [&](const char* name) -> Eigen::RowVector3d {
        return middle.joint_positions.row(skeleton.joint(name));
    };
    CHECK(at("left_hand").x() > 0.3);
    CHECK(at("left_hand").y() < at("left_upper_arm").y());
    CHECK(at("left_toes").z() > at("left_foot").z());
    CHECK((at("left_shin") - at("right_shin").cwiseProduct(Eigen::RowVector3d(-1, 1, 1))).norm() < 0.01);

    const RowMatrix& weights = source.weights();
    CHECK((weights.rowwise().sum().array() - 1.0).abs().maxCoeff() < 1e-9);
    CHECK((weights.array() > 1e-4).cast<int>().rowwise().sum().maxCoeff() <= 16);
}
