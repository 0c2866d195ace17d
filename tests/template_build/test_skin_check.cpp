// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/template_build/skin_check.h"
#include "template_build/doll.h"

#include <catch2/catch.hpp>

#include <utility>

using namespace ndg;
using namespace ndg::test;

namespace {

void check_refused(const ParametricSurface& skin, const std::string& words, const std::string& more = "")
{
    CHECK_THROWS_AS(checked_skin(skin, "body.obj"), InputError);
    CHECK_THROWS_WITH(checked_skin(skin, "body.obj"),
                      Catch::Contains("body.obj") && Catch::Contains(words) && Catch::Contains(more));
}

}  // namespace

TEST_CASE("a good skin passes unchanged")
{
    const Doll doll = make_doll();
    const ParametricSurface checked = checked_skin(doll.surface, "body.obj");
    CHECK(checked.vertices == doll.surface.vertices);
    CHECK(checked.triangles == doll.surface.triangles);
    CHECK(checked.joint_positions == doll.surface.joint_positions);
}

TEST_CASE("skins that are repaired")
{
    const Doll doll = make_doll();
    SECTION("in other units")
    {
        for (const double per_metre : {10.0, 100.0, 1000.0}) {
            ParametricSurface skin = doll.surface;
            skin.vertices *= per_metre;
            skin.joint_positions *= per_metre;
            const ParametricSurface checked = checked_skin(skin, "body.obj");
            CHECK((checked.vertices - doll.surface.vertices).norm() < 1e-9);
            CHECK((checked.joint_positions - doll.surface.joint_positions).norm() < 1e-9);
        }
    }
    SECTION("inside out")
    {
        ParametricSurface skin = doll.surface;
        skin.triangles.col(0).swap(skin.triangles.col(1));
        const ParametricSurface checked = checked_skin(skin, "body.obj");
        CHECK(closed_surface_defect(checked.vertices, checked.triangles).empty());
    }
    SECTION("off the floor")
    {
        ParametricSurface skin = doll.surface;
        skin.vertices.col(1).array() += 0.9;
        skin.joint_positions.col(1).array() += 0.9;
        const ParametricSurface checked = checked_skin(skin, "body.obj");
        CHECK((checked.vertices - doll.surface.vertices).norm() < 1e-9);
        CHECK((checked.joint_positions - doll.surface.joint_positions).norm() < 1e-9);
    }
}

TEST_CASE("skins that are refused")
{
    const Doll doll = make_doll();
    ParametricSurface skin = doll.surface;
    const Eigen::Index count = skin.triangles.rows();
    SECTION("open")
    {
        skin.triangles = doll.surface.triangles.topRows(count - 1);
        check_refused(skin, "open", "1 boundary loop with 3 edges");
    }
    SECTION("open in two places")
    {
        skin.triangles = doll.surface.triangles.middleRows(1, count - 2);
        check_refused(skin, "open", "2 boundary loops");
    }
    SECTION("three triangles at an edge")
    {
        skin.vertices.conservativeResize(skin.vertices.rows() + 1, 3);
        skin.vertices.bottomRows(1) << 0.5, 0.5, 0.5;
        skin.triangles.conservativeResize(count + 1, 3);
        skin.triangles.row(count) << skin.triangles(0, 0), skin.triangles(0, 1), skin.vertices.rows() - 1;
        check_refused(skin, "not manifold", "3 triangles");
    }
    SECTION("a triangle turned over")
    {
        std::swap(skin.triangles(7, 0), skin.triangles(7, 1));
        check_refused(skin, "face opposite ways");
    }
    SECTION("two parts touching at a vertex")
    {
        const Eigen::Index n = skin.vertices.rows();
        skin.vertices.conservativeResize(n + 3, 3);
        skin.vertices.bottomRows(3) = doll.surface.vertices.row(5).replicate(3, 1);
        skin.vertices.bottomRows(3) += 0.01 * Eigen::Matrix3d::Identity();
        skin.triangles.conservativeResize(count + 4, 3);
        const int a = 5, b = static_cast<int>(n), c = b + 1, d = b + 2;
        skin.triangles.bottomRows(4) << a, c, b, a, d, c, a, b, d, b, c, d;
        check_refused(skin, "not manifold", "vertex 5");
    }
    SECTION("in two parts")
    {
        const Eigen::Index n = skin.vertices.rows();
        skin.vertices.conservativeResize(n + 4, 3);
        skin.vertices.bottomRows(4) << 0, 0.5, 0, 0.01, 0.5, 0, 0, 0.51, 0, 0, 0.5, 0.01;
        skin.triangles.conservativeResize(count + 4, 3);
        const int a = static_cast<int>(n), b = a + 1, c = a + 2, d = a + 3;
        skin.triangles.bottomRows(4) << a, c, b, a, d, c, a, b, d, b, c, d;
        check_refused(skin, "2 parts", "4 vertices");
    }
    SECTION("an unused vertex, an index out of range, a triangle with one vertex twice, not a number")
    {
        skin.vertices.conservativeResize(skin.vertices.rows() + 1, 3);
        skin.vertices.bottomRows(1).setZero();
        check_refused(skin, "belongs to no triangle");
        skin = doll.surface;
        skin.triangles(3, 1) = -2;
        check_refused(skin, "triangle 3", "-2");
        skin = doll.surface;
        skin.triangles(3, 1) = skin.triangles(3, 0);
        check_refused(skin, "triangle 3", "twice");
        skin = doll.surface;
        skin.vertices(4, 2) = std::nan("");
        check_refused(skin, "vertex 4", "finite");
    }
    SECTION("z up")
    {
        skin.vertices.col(1).swap(skin.vertices.col(2));
        skin.vertices.col(0) *= -1.0;
        check_refused(skin, "y up");
    }
    SECTION("no adult's size")
    {
        skin.vertices *= 0.4;
        check_refused(skin, "stature");
        skin = doll.surface;
        skin.vertices.col(2) *= 0.1;
        skin.joint_positions.col(2) *= 0.1;
        check_refused(skin, "litres", "no adult");
    }
    SECTION("joints elsewhere")
    {
        skin.joint_positions *= 100.0;
        check_refused(skin, "outside the skin's box");
    }
    SECTION("back to front")
    {
        skin.vertices.col(2) *= -1.0;
        skin.vertices.col(0) *= -1.0;
        skin.joint_positions.col(2) *= -1.0;
        skin.joint_positions.col(0) *= -1.0;
        check_refused(skin, "left hand");
    }
}
