// SPDX-License-Identifier: Apache-2.0
// What animate shows of a motion: the method's own anatomy, frame rates, one body.
#include "ndg/display/motion_display.h"

#include "ndg/core/error.h"
#include "ndg/deform/animate.h"
#include "ndg/deform/rigid_parts.h"
#include "ndg/display/sample_frames.h"
#include "ndg/io/mesh.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <filesystem>

using namespace ndg;
using Catch::Matchers::Contains;

namespace {

struct Scene : SampleInputs {
    test::TemporaryFolder folder;

    Scene()
    {
        body_template = test::tube_template(5, 6);
        bodies.bodies = {body_template.rest, body_template.rest};
        for (const double angle : {0.0, 0.4, 0.9}) {
            poses.poses.push_back(test::tube_pose(angle));
            poses.clip_idx.push_back(0);
            poses.frame_idx.push_back(3 * int(poses.clip_idx.size()));
            samples.pairs.push_back({0, int(poses.clip_idx.size()) - 1});
            samples.pair_splits.push_back("test");
        }
        poses.clip_names = {"bends"};
        poses.clip_frame_rates = {30.0};
        samples.posing = test::bending;
    }
};

PoseSet poses_of(const std::vector<int>& clips, const std::vector<int>& frames, const std::vector<double>& rates)
{
    PoseSet poses;
    poses.clip_idx = clips;
    poses.frame_idx = frames;
    poses.clip_frame_rates = rates;
    return poses;
}

}  // namespace

TEST_CASE_METHOD(Scene, "Meshes hold the anatomy as the method moves it, every frame")
{
    RigidParts parts(body_template);
    const std::string path = folder.file("parts.h5");
    animate_samples(*this, parts, "Rigid parts", {path, ""}, Provenance{});
    MotionDisplay display;
    display.mesh = folder.file("bones_{}.ply");
    display.page = folder.file("page.html");
    display.surface = "bones";
    display.check(samples, false);
    display.write(*this, open_deformations(path), parts, "");
    CHECK(std::filesystem::file_size(display.page) > 100000);
    const BodyPoser poser(body_template, test::bending);
    const AnatomyPart& bone = body_template.anatomy_parts[0];
    double moved = 0.0;
    for (int f = 0; f < 3; ++f) {
        const PosedBody posed = poser.pose(bodies.bodies[0], poses.poses[f]);
        const Points expected = parts.anatomy(posed, body_template.anatomy_vertices, parts.deform(posed))
                                    .middleRows(bone.vertex_begin, bone.vertex_end - bone.vertex_begin);
        const Points carried = posed.anatomy(body_template.anatomy_vertices, parts.deform(posed))
                                   .middleRows(bone.vertex_begin, bone.vertex_end - bone.vertex_begin);
        const Points written = read_mesh(folder.file("bones_" + std::to_string(f) + ".ply")).vertices;
        REQUIRE(written.rows() == expected.rows());
        CHECK((written - expected).cwiseAbs().maxCoeff() < 1e-6);
        moved = std::max(moved, (carried - expected).cwiseAbs().maxCoeff());
    }
    CHECK(moved > 1e-3);
    CHECK_THROWS_WITH(display.check(samples, false), Contains("bones_0.ply"));
    CHECK_NOTHROW(display.check(samples, true));
}

TEST_CASE_METHOD(Scene, "Meshes and pages are of one body, pictures of any")
{
    samples.pairs[2].body_idx = 1;
    MotionDisplay display;
    CHECK_FALSE(display.wanted());
    display.picture = folder.file("picture.png");
    CHECK(display.wanted());
    CHECK_NOTHROW(display.check(samples, false));
    display.page = folder.file("page.html");
    CHECK_THROWS_WITH(display.check(samples, false), Contains("--body"));
    samples.pairs[2].body_idx = 0;
    display.mesh = folder.file("mesh.nothing");
    CHECK_THROWS_WITH(display.check(samples, false), Contains(".glb"));
    display.mesh = folder.file("volume.xdmf");
    CHECK_THROWS_WITH(display.check(samples, false), Contains("volume.xdmf holds prisms"));
}

TEST_CASE("Motions are shown at the rate they were thinned to, what is none slowly")
{
    CHECK(shown_frame_rate(poses_of({0, 0, 0}, {0, 4, 8}, {120.0}), {0, 1, 2}) == 30.0);
    CHECK(shown_frame_rate(poses_of({0, 0, 0}, {0, 4, 8}, {120.0}), {0, 2}) == 15.0);
    CHECK(shown_frame_rate(poses_of({0, 0, 0}, {0, 4, 9}, {120.0}), {0, 1, 2}) == 1.5);
    CHECK(shown_frame_rate(poses_of({0, 0, 0}, {8, 4, 0}, {120.0}), {0, 1, 2}) == 1.5);
    CHECK(shown_frame_rate(poses_of({0}, {7}, {120.0}), {0}) == 1.5);
    // Clips one after the other play on where their rates agree.
    CHECK(shown_frame_rate(poses_of({0, 0, 1, 1}, {0, 4, 0, 1}, {120.0, 30.0}), {0, 1, 2, 3}) == 30.0);
    CHECK(shown_frame_rate(poses_of({0, 0, 1, 1}, {0, 4, 0, 1}, {120.0, 25.0}), {0, 1, 2, 3}) == 1.5);
    CHECK(shown_frame_rate(poses_of({0, 0, 1, 0}, {0, 4, 0, 12}, {120.0, 30.0}), {0, 1, 2, 3}) == 1.5);
}
