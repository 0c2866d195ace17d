// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/template_build/template_check.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>

using namespace ndg;
using namespace ndg::test;

namespace {

constexpr double cone_height = 0.1;  // m

bool fails_with(const TemplateCheck& check, const std::string& words)
{
    const auto failures = check.failures();
    return std::any_of(failures.begin(), failures.end(),
                       [&](const std::string& sentence) { return sentence.find(words) != std::string::npos; });
}

const SegmentMeasure& segment(const TemplateCheck& check, const std::string& name)
{
    const auto found = std::find_if(check.segments.begin(), check.segments.end(),
                                    [&](const SegmentMeasure& s) { return s.name == name; });
    REQUIRE(found != check.segments.end());
    return *found;
}

/// A tube whose skin closes in cones, clear of the ends of the wraps.
Template closed_tube()
{
    Template tube = tube_template(13, 16);
    tube.rest.skin_vertices.bottomRows(2) << 0.0, -cone_height, 0.0, 0.0, 1.0 + cone_height, 0.0;
    return tube;
}

/// Area of a regular polygon.
double polygon_area(int corners, double radius)
{
    return 0.5 * corners * radius * radius * std::sin(2.0 * M_PI / corners);
}

}  // namespace

TEST_CASE("template check: a sound tube passes")
{
    constexpr int rings = 13, segments = 16;
    const Template tube = closed_tube();
    const TemplateCheck check = check_template(tube);
    INFO(template_report(check));
    CHECK(check.passes());
    CHECK(check.skin_defect.empty());
    CHECK(check.wrap_defect.empty());
    CHECK(check.border_vertices == std::vector<int>{segments, segments});
    CHECK(check.wrap_vertices == rings * segments);
    CHECK(check.prisms == 4 * (rings - 1) * segments);
    CHECK(check.bones == 1);
    CHECK(check.muscles == 1);
    CHECK(check.num_intersections() == 0);
    // Radii 0.03, 0.06 and 0.08 m.
    CHECK(check.muscle_thickness.min == Approx(0.03).epsilon(1e-4));
    CHECK(check.muscle_thickness.max == Approx(0.03).epsilon(1e-4));
    CHECK(check.fat_thickness.mean == Approx(0.02).epsilon(1e-4));
    const auto prisms_in = [](const JacobianCheck& layer) {
        return std::accumulate(layer.histogram.begin(), layer.histogram.end(), 0);
    };
    CHECK(prisms_in(check.muscle_jacobians) == check.prisms / 2);
    CHECK(prisms_in(check.fat_jacobians) == check.prisms / 2);
    CHECK(std::min(check.muscle_jacobians.min_scaled, check.fat_jacobians.min_scaled) ==
          Approx(min_scaled_jacobian(tube.rest.volume_vertices, tube.prisms)).epsilon(1e-3));
    CHECK(check.coverage.num_volumetric == tube.anatomy_vertices.rows());
    CHECK(check.coverage.num_inside == tube.anatomy_vertices.rows());
    CHECK(check.weights.num_joints_used == 2);
    CHECK(check.weights.worst_row_sum < 1e-12);
    CHECK(check.bones_inside.num_outside == 0);
    CHECK(check.muscles_inside.share() == 1.0);
}

TEST_CASE("template check: volumes and masses of the tube")
{
    constexpr int segments = 16;
    const Template tube = closed_tube();
    const TemplateCheck check = check_template(tube);
    const double interior = polygon_area(segments, 0.03), muscle = polygon_area(segments, 0.06) - interior,
                 fat = polygon_area(segments, 0.08) - polygon_area(segments, 0.06);  // times the length of 1 m
    const SegmentMeasure& whole = segment(check, "whole body");
    CHECK(whole.interior == Approx(interior).epsilon(1e-5));
    CHECK(whole.muscle == Approx(muscle).epsilon(1e-5));
    CHECK(whole.fat == Approx(fat).epsilon(1e-5));
    const double bone = enclosed_volume(tube.anatomy_vertices.topRows(tube.anatomy_parts[0].vertex_end),
                                        tube.anatomy_triangles.topRows(tube.anatomy_parts[0].triangle_end));
    CHECK(whole.bones == Approx(bone).epsilon(1e-5));
    // All of it is arm: bones 1300, soft tissue 1060, fat 900 kg/m^3.
    CHECK(whole.mass == Approx(1300.0 * bone + 1060.0 * (interior - bone + muscle) + 900.0 * fat).epsilon(1e-5));
    // Upper arm and forearm share the tube; their weights are equal at half its length.
    const SegmentMeasure &upper = segment(check, "left_upper_arm"), &lower = segment(check, "left_forearm");
    CHECK(upper.volume() + lower.volume() == Approx(whole.volume()));
    CHECK(upper.volume() == Approx(0.5 * whole.volume()).epsilon(0.06));
    CHECK(check.skin_volume == Approx(polygon_area(segments, 0.08) * (1.0 + 2.0 * cone_height / 3.0)).epsilon(1e-5));
}

TEST_CASE("template check: what is wrong is found")
{
    Template tube = closed_tube();
    const int n = tube.num_wrap_vertices();
    SECTION("a muscle wrap vertex outside the skin")
    {
        const int v = n / 2;
        tube.rest.volume_vertices.row(n + v) +=
            1.5 * (tube.rest.volume_vertices.row(2 * n + v) - tube.rest.volume_vertices.row(n + v));
        const TemplateCheck check = check_template(tube);
        CHECK(check.fat_jacobians.num_invalid > 0);
        CHECK(check.muscle_jacobians.num_invalid == 0);
        CHECK(check.skin_muscle > 0);
        CHECK(fails_with(check, "invalid"));
        CHECK(fails_with(check, "intersect"));
    }
    SECTION("a flat prism")
    {
        const int v = n / 2;
        tube.rest.volume_vertices.row(n + v) =
            0.03 * tube.rest.volume_vertices.row(n + v) + 0.97 * tube.rest.volume_vertices.row(2 * n + v);
        const TemplateGates gates{0.5, 0.999, 0.0005};
        const TemplateCheck check = check_template(tube, gates);
        CHECK(check.fat_jacobians.num_invalid == 0);
        CHECK(fails_with(check, "scaled Jacobian"));
        CHECK(check.fat_thickness.min == Approx(0.03 * 0.02).epsilon(0.01));
    }
    SECTION("a bone beyond the bone wrap")
    {
        tube.anatomy_vertices.row(3) << 0.0, 0.5, 0.034;  // 4 mm outside the wrap's corners, more of its sides
        const TemplateCheck check = check_template(tube);
        CHECK(check.bones_inside.num_outside == 1);
        CHECK(check.bones_inside.worst_excess > 0.0039);
        CHECK(check.bones_inside.worst_excess < 0.0061);
        CHECK(check.bones_inside.worst.at(0).part == "shaft");
        CHECK(check.muscles_inside.num_outside == 0);
        CHECK(fails_with(check, "bone wrap"));
        // Its embedding still takes it where it was.
        CHECK(check.coverage.num_far == 1);
        CHECK(fails_with(check, "every element"));
    }
    SECTION("an embedding off by less than the limit")
    {
        tube.anatomy_vertices(3, 1) += 0.0004;
        const TemplateCheck check = check_template(tube);
        CHECK(check.coverage.num_near == 1);
        CHECK(check.coverage.num_far == 0);
        CHECK(check.passes());
    }
    SECTION("vertices moved by skinning are not counted")
    {
        tube.embedding.elements[3] = -1;
        tube.anatomy_vertices.row(3) << 0.0, 2.0, 0.0;
        const TemplateCheck check = check_template(tube);
        CHECK(check.coverage.num_skinned == 1);
        CHECK(check.coverage.num_volumetric == tube.anatomy_vertices.rows() - 1);
        CHECK(check.passes());
    }
    SECTION("an inverted tetrahedron")
    {
        std::swap(tube.tetrahedra(5, 0), tube.tetrahedra(5, 1));
        const TemplateCheck check = check_template(tube);
        CHECK(check.num_flat_tetrahedra == 1);
        CHECK(fails_with(check, "tetrahedra"));
    }
    SECTION("an open skin that cuts itself")
    {
        tube.skin_triangles.conservativeResize(tube.skin_triangles.rows() - 1, 3);
        tube.rest.skin_vertices.bottomRows(1) << 0.0, 0.45, 0.0;
        tube.rest.skin_vertices.row(tube.rest.skin_vertices.rows() - 2) << 0.0, 0.55, 0.0;
        const TemplateCheck check = check_template(tube);
        CHECK(check.skin_self > 0);
        CHECK(fails_with(check, "open"));
    }
    SECTION("weights and joints")
    {
        tube.skin_weights.weights(2, 0) += 0.25;
        tube.rest.joint_positions.row(4) << 3.0, 0.0, 0.0;
        const TemplateCheck check = check_template(tube);
        CHECK(check.weights.worst_row_sum == Approx(0.25));
        const auto found = std::find_if(check.joints_outside.begin(), check.joints_outside.end(),
                                        [&](const auto& joint) { return joint.part == tube.skeleton.joint_names[4]; });
        REQUIRE(found != check.joints_outside.end());
        CHECK(found->distance == Approx(3.0 - 0.08).epsilon(0.01));
    }
}

TEST_CASE("template check: rounding to float32 counts")
{
    Template tube = tube_template(7, 8);
    // So far away that float32 places are 1 m apart.
    for (Points* points : {&tube.rest.skin_vertices, &tube.rest.volume_vertices, &tube.rest.interior_vertices,
                           &tube.rest.joint_positions, &tube.anatomy_vertices})
        points->col(0).array() += 1.6e7;
    CHECK(check_prisms(tube.rest.volume_vertices, tube.prisms).num_invalid == 0);
    CHECK(check_template(tube).muscle_jacobians.num_invalid + check_template(tube).fat_jacobians.num_invalid > 0);
}

TEST_CASE("ndg-info checks templates")
{
    const TemporaryFolder folder;
    Template tube = closed_tube();
    write_template(folder.file("good.h5"), tube, {});
    const CommandResult good = run_command(tool_path("ndg-info") + " " + folder.file("good.h5"));
    INFO(good.output);
    CHECK(good.exit_code == 0);
    for (const char* part : {"/volume/prisms", "template check", "result              passes", "left_forearm"})
        CHECK_THAT(good.output, Catch::Contains(part));
    tube.anatomy_vertices.row(3) << 0.0, 0.5, 0.034;
    write_template(folder.file("bad.h5"), tube, {});
    const CommandResult bad = run_command(tool_path("ndg-info") + " " + folder.file("bad.h5"));
    INFO(bad.output);
    CHECK(bad.exit_code == 3);
    CHECK_THAT(bad.output, Catch::Contains("inside the bone wrap") && Catch::Contains("shaft"));
}
