// SPDX-License-Identifier: Apache-2.0
#include "body_source/capsule.h"
#include "ndg/body_source/skin_depth.h"

#include <catch2/catch.hpp>

using namespace ndg;
using test::capsule;

TEST_CASE("Air does not reach a cavity behind a narrow opening")
{
    // A hollow ball whose cavity is closed: its inner wall is no outer surface.
    const AnatomyMesh outer = capsule("", "", 0.10, 0.0, {0, 0, 0});
    AnatomyMesh inner = capsule("", "", 0.03, 0.0, {0, 0, 0});
    inner.triangles.col(0).swap(inner.triangles.col(1));
    Points vertices(outer.vertices.rows() + inner.vertices.rows(), 3);
    vertices << outer.vertices, inner.vertices;
    Triangles triangles(outer.triangles.rows() + inner.triangles.rows(), 3);
    triangles << outer.triangles, (inner.triangles.array() + int(outer.vertices.rows())).matrix();
    const SkinDepth skin(vertices, triangles);
    CHECK(skin.at({0, 0, 0}, true).depth == Approx(-0.03).margin(1e-3));
    CHECK(skin.at({0, 0, 0}, false).depth == Approx(0.10).margin(1e-3));
    CHECK(skin.at({0.05, 0, 0}, true).depth == Approx(0.02).margin(1e-3));
    CHECK(skin.at({0.05, 0, 0}, false).depth == Approx(0.05).margin(1e-3));
    CHECK(skin.at({0.12, 0, 0}, false).depth == Approx(-0.02).margin(1e-3));
}
