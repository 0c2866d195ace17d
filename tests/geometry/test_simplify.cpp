// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/geometry/simplify.h"
#include "ndg/geometry/triangle_mesh.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;

namespace {

/// Ball of `rings` rings of `segments` vertices, outward.
TriangleMesh ball(double radius, int rings, int segments, const Eigen::RowVector3d& centre = {0, 0, 0})
{
    TriangleMesh mesh;
    mesh.vertices.resize(rings * segments + 2, 3);
    for (int r = 0; r < rings; ++r)
        for (int s = 0; s < segments; ++s) {
            const double polar = M_PI * (r + 1) / (rings + 1), around = 2 * M_PI * s / segments;
            mesh.vertices.row(r * segments + s) =
                centre + radius * Eigen::RowVector3d(std::sin(polar) * std::cos(around), std::cos(polar),
                                                     -std::sin(polar) * std::sin(around));
        }
    const int top = rings * segments, bottom = top + 1;
    mesh.vertices.row(top) = centre + Eigen::RowVector3d(0, radius, 0);
    mesh.vertices.row(bottom) = centre - Eigen::RowVector3d(0, radius, 0);
    std::vector<Eigen::RowVector3i> triangles;
    for (int s = 0; s < segments; ++s) {
        const int next = (s + 1) % segments, last = (rings - 1) * segments;
        triangles.emplace_back(top, s, next);
        triangles.emplace_back(bottom, last + next, last + s);
        for (int r = 0; r + 1 < rings; ++r) {
            const int a = r * segments + s, b = r * segments + next, c = a + segments, d = b + segments;
            triangles.emplace_back(a, c, b);
            triangles.emplace_back(b, c, d);
        }
    }
    mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
    for (std::size_t t = 0; t < triangles.size(); ++t) mesh.triangles.row(Eigen::Index(t)) = triangles[t];
    return mesh;
}

TriangleMesh together(const TriangleMesh& a, const TriangleMesh& b)
{
    TriangleMesh mesh;
    mesh.vertices.resize(a.vertices.rows() + b.vertices.rows(), 3);
    mesh.vertices << a.vertices, b.vertices;
    mesh.triangles.resize(a.triangles.rows() + b.triangles.rows(), 3);
    mesh.triangles << a.triangles, (b.triangles.array() + int(a.vertices.rows())).matrix();
    return mesh;
}

/// Every triangle with its own three vertices, as files doubled for their normals have them.
TriangleMesh torn(const TriangleMesh& mesh)
{
    TriangleMesh result;
    result.vertices.resize(3 * mesh.triangles.rows(), 3);
    result.triangles.resize(mesh.triangles.rows(), 3);
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t)
        for (int k = 0; k < 3; ++k) {
            result.vertices.row(3 * t + k) = mesh.vertices.row(mesh.triangles(t, k));
            result.triangles(t, k) = int(3 * t + k);
        }
    return result;
}

}  // namespace

TEST_CASE("Open edges are counted one by one")
{
    TriangleMesh mesh = ball(1.0, 5, 8);
    CHECK(count_open_edges(mesh.triangles) == 0);
    const Triangles without_one = mesh.triangles.topRows(mesh.triangles.rows() - 1);
    CHECK(count_open_edges(without_one) == 3);
    mesh.triangles.row(0).reverseInPlace();
    CHECK(count_open_edges(mesh.triangles) == 6);
}

TEST_CASE("Repair merges, fills and turns outward")
{
    const TriangleMesh whole = ball(0.05, 9, 14);
    const double volume = enclosed_volume(whole.vertices, whole.triangles);
    TriangleMesh mesh = torn(whole);
    SECTION("torn into single triangles")
    {
        const TriangleMesh repaired = repair_closed(mesh.vertices, mesh.triangles, 1e-6);
        CHECK(repaired.vertices.rows() == whole.vertices.rows());
        CHECK(closed_surface_defect(repaired.vertices, repaired.triangles).empty());
        CHECK(enclosed_volume(repaired.vertices, repaired.triangles) == Approx(volume));
    }
    SECTION("inside out")
    {
        mesh.triangles.col(0).swap(mesh.triangles.col(1));
        const TriangleMesh repaired = repair_closed(mesh.vertices, mesh.triangles, 1e-6);
        CHECK(enclosed_volume(repaired.vertices, repaired.triangles) == Approx(volume));
    }
    SECTION("with holes")
    {
        Triangles some(mesh.triangles.rows() - 3, 3);
        some << mesh.triangles.middleRows(1, 80), mesh.triangles.middleRows(82, 60),
            mesh.triangles.middleRows(143, mesh.triangles.rows() - 143);
        const TriangleMesh repaired = repair_closed(mesh.vertices, some, 1e-6);
        CHECK(count_open_edges(repaired.triangles) == 0);
        CHECK(enclosed_volume(repaired.vertices, repaired.triangles) == Approx(volume).epsilon(0.02));
    }
    SECTION("doubled and flat triangles")
    {
        Triangles more(mesh.triangles.rows() + 2, 3);
        more << mesh.triangles, mesh.triangles.row(5), Eigen::RowVector3i(0, 0, 4);
        const TriangleMesh repaired = repair_closed(mesh.vertices, more, 1e-6);
        CHECK(repaired.triangles.rows() == whole.triangles.rows());
    }
    SECTION("a hidden cavity and a scrap go, a second ball stays")
    {
        const TriangleMesh many = together(together(whole, ball(0.02, 7, 10)),
                                           together(ball(0.03, 7, 10, {0.2, 0, 0}), ball(0.001, 3, 4, {-0.2, 0, 0})));
        const TriangleMesh repaired = repair_closed(many.vertices, many.triangles, 1e-6);
        const TriangleMesh second = ball(0.03, 7, 10, {0.2, 0, 0});
        CHECK(enclosed_volume(repaired.vertices, repaired.triangles) ==
              Approx(volume + enclosed_volume(second.vertices, second.triangles)));
        CHECK(repaired.vertices.rows() == whole.vertices.rows() + second.vertices.rows());
    }
    SECTION("nothing to close")
    {
        CHECK_THROWS_AS(repair_closed(mesh.vertices, Triangles(0, 3), 1e-6), InputError);
    }
}

TEST_CASE("Simplification keeps surfaces closed and in place")
{
    const TriangleMesh whole = ball(0.05, 39, 60);
    const TriangleMesh simple = simplify_closed(whole, 300);
    CHECK(simple.vertices.rows() == 300);
    CHECK(closed_surface_defect(simple.vertices, simple.triangles).empty());
    CHECK(enclosed_volume(simple.vertices, simple.triangles) ==
          Approx(enclosed_volume(whole.vertices, whole.triangles)).epsilon(0.03));
    CHECK((simple.vertices.rowwise().norm().array() - 0.05).abs().maxCoeff() < 0.002);
    CHECK(simplify_closed(whole, 100000).vertices.rows() == whole.vertices.rows());
    CHECK_THROWS_AS(simplify_closed({whole.vertices, whole.triangles.topRows(9)}, 100), InputError);
}
