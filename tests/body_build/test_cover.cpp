// SPDX-License-Identifier: Apache-2.0
#include "ndg/body_build/cover.h"
#include "ndg/body_source/anatomy_depth.h"
#include "ndg/core/error.h"
#include "ndg/geometry/triangle_mesh.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

using namespace ndg;

namespace {

/// A capsule around the segment from (0, -half, 0) to (0, half, 0), outward; a ball for half = 0.
AnatomyMesh capsule(const std::string& name, const std::string& layer, double radius, double half,
                    const Eigen::RowVector3d& centre, int rings = 30, int segments = 36)
{
    AnatomyMesh part;
    part.name = name;
    part.layer = parse_name<AnatomyLayer>(layer);
    part.vertices.resize(rings * segments + 2, 3);
    for (int r = 0; r < rings; ++r)
        for (int s = 0; s < segments; ++s) {
            const double polar = M_PI * (r + 1) / (rings + 1), around = 2 * M_PI * s / segments;
            const double lift = half * std::clamp(std::cos(polar) * 2.0, -1.0, 1.0);
            part.vertices.row(r * segments + s) =
                centre + Eigen::RowVector3d(radius * std::sin(polar) * std::cos(around),
                                            radius * std::cos(polar) + lift,
                                            -radius * std::sin(polar) * std::sin(around));
        }
    const int top = rings * segments, bottom = top + 1;
    part.vertices.row(top) = centre + Eigen::RowVector3d(0, radius + half, 0);
    part.vertices.row(bottom) = centre - Eigen::RowVector3d(0, radius + half, 0);
    part.triangles.resize(2 * rings * segments, 3);
    Eigen::Index t = 0;
    for (int s = 0; s < segments; ++s) {
        const int next = (s + 1) % segments, last = (rings - 1) * segments;
        part.triangles.row(t++) << top, s, next;
        part.triangles.row(t++) << bottom, last + next, last + s;
        for (int r = 0; r + 1 < rings; ++r) {
            const int a = r * segments + s, b = r * segments + next, c = a + segments, d = b + segments;
            part.triangles.row(t++) << a, c, b;
            part.triangles.row(t++) << b, c, d;
        }
    }
    return part;
}

}  // namespace

TEST_CASE("Cover pushes a ball that touches the skin inwards, and its neighbour with it")
{
    const AnatomyMesh skin = capsule("skin", "", 0.10, 0.0, {0, 0, 0});
    // The bone sticks 3 mm out of the skin; the muscle lies behind it, 2 mm away.
    std::vector<AnatomyMesh> anatomy = {capsule("bone", "bone", 0.03, 0.0, {0.073, 0, 0}),
                                        capsule("muscle", "muscle", 0.02, 0.0, {0.021, 0, 0}),
                                        capsule("far", "muscle", 0.02, 0.0, {-0.06, 0, 0})};
    const std::vector<AnatomyMesh> before = anatomy;
    const CoverReport report = cover_with_skin(skin.vertices, skin.triangles, anatomy, {});
    CHECK(report.min_bone_before == Approx(-0.003).margin(1e-4));
    CHECK(report.worst_bone == "bone");
    CHECK(report.min_bone >= 0.004 - 1e-9);
    CHECK(report.min_muscle >= 0.0025 - 1e-9);
    CHECK(report.thin_vertices == 0);
    CHECK(report.max_displacement > 0.0069);
    CHECK(report.max_displacement < 0.012);
    // Independently: every vertex lies within the radius less the cover (less the skin's own facets).
    CHECK(anatomy[0].vertices.rowwise().norm().maxCoeff() < 0.10 - 0.004 + 1e-5);
    CHECK((anatomy[0].triangles.array() == before[0].triangles.array()).all());
    // Bone and muscle still do not overlap along the line between them, and what is far away has not moved.
    CHECK(anatomy[0].vertices.col(0).minCoeff() > anatomy[1].vertices.col(0).maxCoeff());
    CHECK((anatomy[2].vertices - before[2].vertices).rowwise().norm().maxCoeff() < 5e-4);
    // No triangle is turned over: the bone is still an outward ball of about its volume.
    CHECK(closed_surface_defect(anatomy[0].vertices, anatomy[0].triangles).empty());
    CHECK(enclosed_volume(anatomy[0].vertices, anatomy[0].triangles) >
          0.7 * enclosed_volume(before[0].vertices, before[0].triangles));
}

TEST_CASE("Cover leaves alone what has enough")
{
    const AnatomyMesh skin = capsule("skin", "", 0.08, 0.2, {0, 1, 0});
    std::vector<AnatomyMesh> anatomy = {capsule("bone", "bone", 0.02, 0.2, {0, 1, 0}),
                                        capsule("muscle", "muscle", 0.07, 0.19, {0, 1, 0})};
    const std::vector<AnatomyMesh> before = anatomy;
    const CoverReport report = cover_with_skin(skin.vertices, skin.triangles, anatomy, {});
    CHECK(report.moved_vertices == 0);
    CHECK(report.max_displacement == 0.0);
    CHECK(anatomy[1].vertices == before[1].vertices);
}

TEST_CASE("A limb thinner than the cover asks for gets a share of it")
{
    const AnatomyMesh skin = capsule("skin", "", 0.007, 0.04, {0, 0, 0});
    std::vector<AnatomyMesh> anatomy = {capsule("phalanx", "bone", 0.006, 0.03, {0.0015, 0, 0})};
    const CoverReport report = cover_with_skin(skin.vertices, skin.triangles, anatomy, {});
    CHECK(report.min_bone_before < 0.0);
    CHECK(report.thin_vertices > 0);
    CHECK(report.min_thin > 0.0015);
    CHECK(enclosed_volume(anatomy[0].vertices, anatomy[0].triangles) > 0.0);
}

TEST_CASE("The same cover comes out twice, and bad options are refused")
{
    const AnatomyMesh skin = capsule("skin", "", 0.05, 0.1, {0, 0, 0});
    std::vector<AnatomyMesh> first = {capsule("muscle", "muscle", 0.05, 0.1, {0.004, 0, 0.002})};
    std::vector<AnatomyMesh> second = first;
    cover_with_skin(skin.vertices, skin.triangles, first, {});
    cover_with_skin(skin.vertices, skin.triangles, second, {});
    CHECK(first[0].vertices == second[0].vertices);
    CHECK_THROWS_AS(cover_with_skin(skin.vertices, skin.triangles, first, {0.0, 0.001}), InputError);
}

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
