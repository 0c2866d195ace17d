// SPDX-License-Identifier: Apache-2.0
#include "geometry/shapes.h"
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/io/mesh.h"
#include "ndg/protrusion/external_frames.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <filesystem>

using namespace ndg;

namespace {

constexpr double radius = 0.1;

/// A ball for a skin.
FrameSkin ball()
{
    const test::Surface sphere = test::icosphere(radius, 4);
    return {sphere.vertices, sphere.triangles, std::vector<char>(sphere.triangles.rows(), 1)};
}

/// A bone: a ball of 1 cm with its centre at distance `x` along the axis on which the skin has a vertex.
test::Surface bone(double distance, int axis_vertex = 0)
{
    test::Surface surface = test::icosphere(0.01, 2);
    const Eigen::RowVector3d direction = ball().vertices.row(axis_vertex).normalized();
    surface.vertices.rowwise() += distance * direction;
    return surface;
}

FrameProtrusion measure(const test::Surface& inside)
{
    return frame_protrusion(ball(), inside.vertices, inside.triangles);
}

/// One triangle whose first corner lies at `distance` from the centre of the skin, the others deep inside.
test::Surface spike(double distance)
{
    test::Surface surface;
    surface.vertices.resize(3, 3);
    surface.vertices.row(0) = distance * ball().vertices.row(0).normalized();
    surface.vertices.row(1) << 0.01, 0, 0;
    surface.vertices.row(2) << 0, 0.01, 0;
    surface.triangles.resize(1, 3);
    surface.triangles << 0, 1, 2;
    return surface;
}

}  // namespace

TEST_CASE("A vertex 2 mm outside of a sphere protrudes by 2 mm")
{
    const FrameProtrusion frame = measure(spike(radius + 0.002));
    CHECK(frame.intersecting == std::vector<int>{0});
    CHECK(frame.protruding_vertices == 1);
    CHECK(frame.depth_sum_mm == Approx(2.0).epsilon(1e-6));
    CHECK(frame.max_depth_mm == frame.depth_sum_mm);
    CHECK(frame.deepest_vertex == 0);
    const FrameProtrusion inside = measure(spike(radius - 0.002));
    CHECK(inside.intersecting.empty());
    CHECK(inside.protruding_vertices == 0);
}

TEST_CASE("A bone that sticks out by 3 mm does so, one that is inside or wholly outside is told apart")
{
    const FrameProtrusion out = measure(bone(radius - 0.01 + 0.003));
    CHECK_FALSE(out.intersecting.empty());
    CHECK(out.protruding_vertices > 0);
    CHECK(out.protruding_vertices < bone(0).vertices.rows() / 2);
    CHECK(out.max_depth_mm == Approx(3.0).epsilon(0.02));  // the sphere is faceted
    const FrameProtrusion inside = measure(bone(radius - 0.01 - 0.003));
    CHECK(inside.intersecting.empty());
    CHECK(inside.protruding_vertices == 0);
    // Far outside: it protrudes although it crosses nothing.
    const FrameProtrusion beyond = measure(bone(radius + 0.03));
    CHECK(beyond.intersecting.empty());
    CHECK(beyond.protruding_vertices == bone(0).vertices.rows());
    CHECK(beyond.max_depth_mm == Approx(40.0).epsilon(0.02));
}

TEST_CASE("What is excluded counts neither as skin nor as anatomy")
{
    const test::Surface out = bone(radius);
    FrameSkin skin = ball();
    skin.compared.assign(skin.compared.size(), 0);
    const FrameProtrusion no_skin = frame_protrusion(skin, out.vertices, out.triangles);
    CHECK(no_skin.intersecting.empty());
    CHECK(no_skin.protruding_vertices == 0);
    // A neck's bone beside a mouth: only what comes out through the compared half counts, and the whole skin says that.
    for (const double side : {1.0, -1.0}) {
        FrameSkin half = ball();
        for (Eigen::Index t = 0; t < half.triangles.rows(); ++t)
            half.compared[t] = side * half.vertices.row(half.triangles(t, 0)).dot(half.vertices.row(0)) > 0;
        const FrameProtrusion frame = frame_protrusion(half, out.vertices, out.triangles);
        CHECK((frame.protruding_vertices > 0) == (side > 0));
        CHECK(frame.intersecting.empty() == (side < 0));
    }
    const FrameProtrusion no_bone = frame_protrusion(ball(), out.vertices, Triangles(0, 3));
    CHECK(no_bone.intersecting.empty());
    CHECK(no_bone.protruding_vertices == 0);
}

TEST_CASE("Where a skin lies twice, through a fold that passes through itself, anatomy is inside")
{
    const test::Surface first = test::icosphere(radius, 4);
    FrameSkin skin;
    skin.vertices.resize(2 * first.vertices.rows(), 3);
    skin.vertices << first.vertices, first.vertices.rowwise() + Eigen::RowVector3d(0.15, 0, 0);
    skin.triangles.resize(2 * first.triangles.rows(), 3);
    skin.triangles << first.triangles, first.triangles.array() + int(first.vertices.rows());
    skin.compared.assign(skin.triangles.rows(), 1);
    test::Surface small = test::icosphere(0.002, 1);
    small.vertices.rowwise() += Eigen::RowVector3d(0.075, 0, 0);
    CHECK(frame_protrusion(skin, small.vertices, small.triangles).protruding_vertices == 0);
}

TEST_CASE("Rows are shares of frames, and the mean distance of all vertices outside")
{
    ProtrusionSum sum("X");
    CHECK_THROWS_AS(sum.row(), Error);
    sum.add({{}, 0, 0, 0, -1}, "frame 0", "", {});
    sum.add({{4, 8}, 0, 0, 0, -1}, "frame 1", "", {"a rib"});
    sum.add({{1}, 3, 6.0, 3.0, 7}, "frame 2", "a rib", {"a rib", "a toe"});
    sum.add({{2}, 1, 4.0, 4.0, 9}, "frame 3", "a toe", {"a rib"});
    const ProtrusionRow row = sum.row();
    CHECK(row.frames == 4);
    CHECK(row.intersecting_frames == 75);
    CHECK(row.protruding_frames == 50);
    CHECK(row.protrusion_mm == 2.5);
    CHECK(row.max_protrusion_mm == 4);
    CHECK(row.deepest == "a toe of frame 3");
    CHECK(row.protruding_parts == std::map<std::string, int>{{"a rib", 1}, {"a toe", 1}});
    CHECK(row.intersecting_parts == std::map<std::string, int>{{"a rib", 3}, {"a toe", 1}});
}

TEST_CASE("Frames of other models are read from a folder of meshes")
{
    const test::TemporaryFolder temporary;
    const std::string folder = temporary.path() + "/MODEL";
    std::filesystem::create_directories(folder);
    const FrameSkin skin = ball();
    const auto put = [&](const std::string& name, const test::Surface& surface) {
        write_mesh(folder + "/" + name, surface.vertices, surface.triangles);
    };
    const std::vector<double> distances = {0.05, 0.097, 0.08};
    for (int i = 0; i < 3; ++i) {
        write_mesh(folder + fmt::format("/skin_{:04}.obj", i), skin.vertices, skin.triangles);
        put(fmt::format("bones_{:04}.ply", i), bone(distances[i]));
        put(fmt::format("lean_tissue_{:04}.obj", i), bone(0.0));
    }
    const ProtrusionRow row = external_protrusion("MODEL", folder);
    CHECK(row.method == "MODEL");
    CHECK(row.frames == 3);
    CHECK(row.intersecting_frames == Approx(100.0 / 3));
    CHECK(row.protruding_frames == Approx(100.0 / 3));
    CHECK(row.max_protrusion_mm == Approx(7.0).epsilon(0.02));
    CHECK(row.deepest == "bones of frame 0001");

    // The vertices of the skin near the one bone that sticks out, left out, take it with them.
    std::string excluded;
    for (Eigen::Index v = 0; v < skin.vertices.rows(); ++v)
        if ((skin.vertices.row(v) - skin.vertices.row(0)).norm() < 0.03) excluded += fmt::format("{}\n", v);
    write_file(folder + "/excluded.txt", excluded);
    CHECK(external_protrusion("MODEL", folder).intersecting_frames == 0);
    CHECK(external_protrusion("MODEL", folder).protruding_frames == 0);

    write_file(folder + "/excluded.txt", "99999999\n");
    CHECK_THROWS_WITH(external_protrusion("MODEL", folder),
                      Catch::Contains("excluded.txt") && Catch::Contains("99999999"));
    std::filesystem::remove(folder + "/excluded.txt");
    std::filesystem::remove(folder + "/skin_0001.obj");
    CHECK_THROWS_WITH(external_protrusion("MODEL", folder), Catch::Contains("0001"));
    write_mesh(folder + "/skin_0001.obj", skin.vertices, skin.triangles.topRows(100));
    CHECK_THROWS_WITH(external_protrusion("MODEL", folder), Catch::Contains("skin_0001.obj"));
    CHECK_THROWS_AS(external_protrusion("MODEL", temporary.path()), InputError);
}
