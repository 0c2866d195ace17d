// SPDX-License-Identifier: Apache-2.0
// Bodies in motion as they are shown, and what is told of surfaces that pass through each other.
#include "support/support.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/display/penetrations.h"
#include "ndg/dynamics/motion_simulation.h"
#include "ndg/dynamics/obstacle.h"

#include <catch2/catch.hpp>

using namespace ndg;

namespace {

/// Two balls of flesh as one skin and a third as an obstacle before them, over three frames: nothing touches; the
/// obstacle is 10 mm inside the first; the second is 20 mm inside the first.
DynamicsSet balls(const test::TemporaryFolder& folder, int held_of_skin, std::vector<Points>& frames)
{
    const TriangleMesh ball = sphere_shape(0.1, 0.03);
    const auto count = static_cast<int>(ball.vertices.rows());
    const auto at = [&](double x) -> Points { return ball.vertices.rowwise() + Eigen::RowVector3d(x, 0, 0); };
    DynamicsSet set;
    set.model = "layered";
    set.key = "key";
    set.convergence_criterion = "none";
    set.time_step_seconds = 1 / 120.0;
    set.frame_rate_hertz = 30;
    set.num_held = count + held_of_skin;
    const auto stack = [&](double obstacle, double first, double second) {
        Points points(3 * count, 3);
        points << at(obstacle), at(first), at(second);
        return points;
    };
    frames = {stack(-0.3, 0, 0.3), stack(-0.19, 0, 0.3), stack(-0.3, 0, 0.18)};
    set.rest = frames[0];
    set.skin_triangles.resize(2 * ball.triangles.rows(), 3);
    set.skin_triangles << (ball.triangles.array() + count).matrix(), (ball.triangles.array() + 2 * count).matrix();
    set.others.push_back({"stone", false, ball.triangles});
    set.sequence_names = {"still"};
    set.frame_begin = {0};
    set.times = {0, 1 / 30.0, 2 / 30.0};
    set.poses.assign(3, Pose::rest(2));
    for (const std::string& name : dynamics_statistics()) set.statistics[name] = {1, 1, 1};
    DynamicsWriter writer(folder.file("balls.h5"), set, {});
    for (int f = 0; f < 3; ++f) {
        const RowMatrixF stored = frames[static_cast<std::size_t>(f)].cast<float>();
        writer.write(f, std::vector<float>(stored.data(), stored.data() + stored.size()));
    }
    writer.commit();
    return set;
}

const PenetrationCount& of(const std::vector<PenetrationCount>& counts, const std::string& inner,
                           const std::string& outer, bool held)
{
    for (const PenetrationCount& count : counts) {
        if (count.inner == inner && count.outer == outer && count.held == held) return count;
    }
    FAIL("nothing is told of " << inner << " in " << outer);
    return counts[0];
}

}  // namespace

TEST_CASE("What is inside of what is told frame by frame, with its depth, apart for skin that is held")
{
    const test::TemporaryFolder folder;
    std::vector<Points> frames;
    const DynamicsSet written = balls(folder, 0, frames);
    const DynamicsReader reader(folder.file("balls.h5"));
    REQUIRE(reader.set().others.size() == 1);
    CHECK(reader.set().others[0].triangles == written.others[0].triangles);
    CHECK(reader.set().poses.size() == 3);
    const DynamicsDisplay display(reader, nullptr);
    CHECK(display.skin(1, reader.frame(1)).rows() == 2 * frames[0].rows() / 3);
    const std::vector<PenetrationCount> counts = count_penetrations(display, 0);
    const PenetrationCount& skin = of(counts, "skin", "stone", false);
    CHECK(skin.frames == 1);
    CHECK(skin.most_vertices >= 1);
    // Of the vertices of triangulated balls.
    CHECK(skin.deepest_metre == Approx(0.01).epsilon(0.15));
    CHECK(skin.deepest_seconds == Approx(1 / 30.0));
    CHECK(of(counts, "stone", "skin", false).deepest_metre == Approx(0.01).epsilon(0.15));
    const PenetrationCount& itself = of(counts, "skin", "itself", false);
    CHECK(itself.frames == 1);
    CHECK(itself.deepest_seconds == Approx(2 / 30.0));
    CHECK(itself.deepest_metre == Approx(0.02).epsilon(0.15));
    for (const PenetrationCount& count : counts) {
        if (count.held) CHECK(count.frames == 0);
    }
    CHECK_THROWS_AS(require_apart(counts), QualityError);
    CHECK_THAT(penetration_lines(counts), Catch::Contains("skin inside stone, where skin gives way: in 1 frames"));
}

TEST_CASE("What goes through held skin is told and is no failure")
{
    const test::TemporaryFolder folder;
    std::vector<Points> frames;
    balls(folder, static_cast<int>(sphere_shape(0.1, 0.03).vertices.rows()), frames);
    const DynamicsReader reader(folder.file("balls.h5"));
    const std::vector<PenetrationCount> counts = count_penetrations(DynamicsDisplay(reader, nullptr), 0);
    CHECK(of(counts, "skin", "stone", true).frames == 1);
    CHECK(of(counts, "stone", "skin", true).frames == 1);
    CHECK(of(counts, "skin", "stone", false).frames == 0);
    CHECK_NOTHROW(require_apart(counts));
}

TEST_CASE("Bodies in motion are sequences of meshes and pages with what they meet")
{
    const test::TemporaryFolder folder;
    std::vector<Points> frames;
    balls(folder, 0, frames);
    const DynamicsReader reader(folder.file("balls.h5"));
    const DynamicsDisplay display(reader, nullptr);
    const MeshSequence sequence = display.sequence(0, "credits");
    REQUIRE(sequence.meshes.size() == 2);
    CHECK(sequence.meshes[1].name == "stone");
    CHECK(sequence.num_frames == 3);
    const std::vector<MeshFrame> second = sequence.frame(1);
    CHECK((second[1].vertices - frames[1].topRows(second[1].vertices.rows())).norm() < 1e-6);
    CHECK(second[1].vertices.rows() == sequence.meshes[1].triangles.maxCoeff() + 1);
    const double error = write_dynamics_page(folder.file("page.html"), display, 0, "credits");
    CHECK(error < 2e-5);
    const std::string page = read_file(folder.file("page.html"));
    CHECK_THAT(page, Catch::Contains("\"num_frames\":3") && Catch::Contains("Simulated"));
    CHECK_THROWS_AS(display.skinned(0), Error);
    Avatar other;
    other.name = "somebody else";
    other.skin_triangles.resize(1, 3);
    CHECK_THROWS_AS(DynamicsDisplay(reader, &other), InputError);
    const VertexColours colours = distance_colours(Eigen::Vector3d(0, 0.01, 1), 0.02);
    CHECK(colours(0, 1) > 0.9f);
    CHECK(colours(2, 1) < 0.1f);
    CHECK(colours(1, 1) == Approx(0.5 * (colours(0, 1) + colours(2, 1))));
}
