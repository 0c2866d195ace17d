// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/makehuman/makehuman.h"
#include "ndg/template_build/landmarks.h"
#include "support/support.h"
#include "template_build/doll.h"

#include <catch2/catch.hpp>

#include <map>

using namespace ndg;
using namespace ndg::test;

namespace {

std::map<std::string, Eigen::Vector3d> by_name(const std::vector<NamedPoint>& landmarks)
{
    std::map<std::string, Eigen::Vector3d> result;
    for (const NamedPoint& point : landmarks) result[point.name] = point.position;
    REQUIRE(result.size() == landmarks.size());  // no name twice
    return result;
}

/// What holds on any upright body.
void check_order(const std::map<std::string, Eigen::Vector3d>& points, const ParametricSurface& surface)
{
    CHECK(points.size() == 41);
    const auto height = [&](const char* name) { return points.at(name)[1]; };
    CHECK(height("vertex") == surface.vertices.col(1).maxCoeff());
    const std::vector<const char*> downwards = {
        "vertex",      "glabella", "nasal_tip", "chin",         "suprasternale",
        "left_nipple", "navel",    "crotch",    "left_patella", "left_malleolus_lateral",
        "left_toe_tip"};
    for (std::size_t i = 1; i < downwards.size(); ++i) {
        INFO(downwards[i]);
        CHECK(height(downwards[i]) < height(downwards[i - 1]));
    }
    CHECK(points.at("nasal_tip")[2] > points.at("opisthocranion")[2]);
    CHECK(points.at("suprasternale")[2] > points.at("cervicale")[2]);
    CHECK(points.at("left_toe_tip")[2] > points.at("left_heel")[2]);
    CHECK(points.at("left_malleolus_lateral")[0] > points.at("left_malleolus_medial")[0]);
    CHECK(points.at("left_metatarsal_5")[0] > points.at("left_metatarsal_1")[0]);
    CHECK(points.at("left_patella")[2] > points.at("left_buttock")[2]);
    const TriangleTree tree(surface.vertices, surface.triangles);
    for (const auto& [name, point] : points) {
        INFO(name);
        CHECK(tree.closest(point).distance < 0.002);
        if (name.rfind("left_", 0) != 0) continue;
        CHECK(point[0] > 0.0);
        const Eigen::Vector3d& right = points.at("right_" + name.substr(5));
        CHECK((right - Eigen::Vector3d(-point[0], point[1], point[2])).norm() < 1e-4);
    }
}

}  // namespace

TEST_CASE("landmarks of a doll")
{
    const Doll doll = make_doll();
    const auto points = by_name(skin_landmarks(doll.surface.vertices, doll.weights, doll.surface.joint_positions));
    check_order(points, doll.surface);
    // Places known from the doll's capsules (its lowest point, about 5 mm under them, was put onto y = 0).
    const double tolerance = 0.02;
    CHECK((points.at("left_fingertip") - Eigen::Vector3d(0.615, 0.805, 0.0)).norm() < tolerance);
    CHECK(points.at("left_patella")[2] == Approx(0.06).margin(0.015));
    CHECK(points.at("left_trochanterion")[0] == Approx(0.17).margin(tolerance));
    CHECK(points.at("left_acromion")[0] == Approx(0.215).margin(tolerance));
    CHECK(points.at("left_toe_tip")[2] == Approx(0.175).margin(tolerance));
}

TEST_CASE("landmarks of a skin without feet")
{
    const Doll doll = make_doll();
    RowMatrix weights = doll.weights;
    const Skeleton& skeleton = standard_skeleton();
    for (const char* joint : {"left_shin", "left_foot", "left_toes"}) {
        weights.col(0) += weights.col(skeleton.joint(joint));
        weights.col(skeleton.joint(joint)).setZero();
    }
    CHECK_THROWS_WITH(skin_landmarks(doll.surface.vertices, weights, doll.surface.joint_positions),
                      Catch::Contains("left_"));
}

TEST_CASE("landmarks of MakeHuman's body")
{
    if (data_folder().empty()) return;
    const MakeHuman source(data_folder() + "/makehuman");
    for (const double sex : {0.0, 1.0}) {
        MakeHumanParameters parameters;
        parameters.sex = sex;
        const ParametricSurface surface = source.evaluate(parameters);
        const auto points = by_name(skin_landmarks(surface.vertices, source.weights(), surface.joint_positions));
        check_order(points, surface);
        const double height = stature(surface.vertices);
        // Shares of stature of the 1988 survey of U.S. Army personnel, within some percent: shoulder 0.82, crotch
        // 0.475, knee 0.28.
        CHECK(points.at("left_acromion")[1] / height == Approx(0.82).margin(0.03));
        CHECK(points.at("crotch")[1] / height == Approx(0.475).margin(0.03));
        CHECK(points.at("left_patella")[1] / height == Approx(0.28).margin(0.03));
    }
}
