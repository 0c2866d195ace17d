// SPDX-License-Identifier: Apache-2.0
// MakeHuman's sliders, which skip without a data folder, and templates of both sources.
#include "ndg/anatomical/source.h"
#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/tetrahedra.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/layers/layer_batch.h"
#include "ndg/makehuman/makehuman.h"
#include "ndg/people/body_sampling.h"
#include "ndg/procedural/body.h"
#include "ndg/template_build/make_template.h"
#include "ndg/template_build/template_check.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <algorithm>

using namespace ndg;
using Catch::Matchers::Contains;

namespace {

/// What every template must keep, whatever it is made from; then a light and a heavy person of the same source.
void check_made(const Template& made, const ParametricSurface& own, const ParametricSurface& lean_surface,
                const ParametricSurface& heavy_surface)
{
    const TemplateCheck check = check_template(made);
    INFO(template_report(check));
    CHECK(check.passes());

    // Muscles bend with the flesh: long triangles would cut across folds of the skin. Bringing muscles under the skin
    // stretches edges a little.
    const TriangleTree skin(made.rest.skin_vertices, made.skin_triangles);
    double longest = 0.0;
    int edges = 0, long_for_their_depth = 0;
    for (const AnatomyPart& part : made.anatomy_parts)
        for (int t = part.triangle_begin; part.layer == AnatomyLayer::muscle && t < part.triangle_end; ++t)
            for (int k = 0; k < 3; ++k) {
                const Eigen::Vector3d a = made.anatomy_vertices.row(made.anatomy_triangles(t, k)).transpose();
                const Eigen::Vector3d b = made.anatomy_vertices.row(made.anatomy_triangles(t, (k + 1) % 3)).transpose();
                const double length = (a - b).norm();
                longest = std::max(longest, length);
                ++edges;
                long_for_their_depth += length > 1.1 * TemplateOptions().shallow_muscle_edge &&
                                        length > 1.1 * 1.5 * skin.closest(0.5 * (a + b)).distance;
            }
    CHECK(longest > 0.010);
    CHECK(longest < 1.1 * TemplateOptions().muscle_edge);
    CHECK(long_for_their_depth < 0.002 * edges);

    // The template's own skin comes back from the source, its joints too.
    const Skin again = skin_on_template(made, own, "again");
    CHECK((again.skin_vertices - made.rest.skin_vertices).cwiseAbs().maxCoeff() < 1e-9);
    CHECK((again.joint_positions - made.rest.joint_positions).cwiseAbs().maxCoeff() < 1e-3);

    LayerReport lean, heavy;
    const Person person{0.5, 40.0};
    const Body lean_body = build_layers(made, skin_on_template(made, lean_surface, "lean"), person, 0.05, &lean);
    const Body heavy_body = build_layers(made, skin_on_template(made, heavy_surface, "heavy"), person, 0.05, &heavy);
    CHECK(check_prisms(lean_body.volume_vertices, made.prisms).num_invalid == 0);
    CHECK(check_prisms(heavy_body.volume_vertices, made.prisms).num_invalid == 0);
    CHECK(heavy.bmi > lean.bmi + 4.0);
    CHECK(heavy.fat_layer_litre > 1.3 * lean.fat_layer_litre);
    // Bones do not grow with fat: the inside of the bone wrap changes far less than the body.
    const auto inside = [&](const Body& body) {
        Points vertices(made.num_wrap_vertices() + body.interior_vertices.rows(), 3);
        vertices << body.volume_vertices.topRows(made.num_wrap_vertices()), body.interior_vertices;
        return tetrahedron_volumes(vertices, made.tetrahedra).sum();
    };
    CHECK(inside(heavy_body) / inside(lean_body) == Approx(1.0).epsilon(0.3));
    CHECK(heavy.mass_kg / lean.mass_kg > 1.25);
    CHECK(lean.fit.mean_skin_displacement < 0.001);
    CHECK(heavy.fit.mean_skin_displacement < 0.001);
    CHECK(heavy.fat_layer_litre == Approx(heavy.wanted_fat_litre).epsilon(0.05));
    CHECK(heavy.girths.abdomen > lean.girths.abdomen + 0.1);
    CHECK(heavy.girths.hip > heavy.girths.thigh);
    CHECK(heavy.girths.thigh > heavy.girths.calf);
    CHECK(heavy.girths.upper_arm > heavy.girths.forearm);

    // A batch: a broken skin is set apart, and what an interrupted run has finished is taken over as it is.
    const test::TemporaryFolder folder;
    SkinSet skins;
    skins.bodies = {skin_on_template(made, lean_surface, "one"), skin_on_template(made, lean_surface, "broken"),
                    skin_on_template(made, heavy_surface, "two")};
    skins.bodies[1].skin_vertices(5, 1) = std::nan("");
    const std::vector<Person> people(3, person);
    const LayerBuilder builder(made, {});
    const PartStore store(folder.file("bodies.h5"), body_parts, "key", false);
    const auto never = [] { return false; };
    const LayerBatch whole = build_layer_batch(builder, skins, people, store, never);
    REQUIRE(whole.bodies.bodies.size() == 2);
    CHECK(whole.failures.size() == 1);
    CHECK(whole.num_resumed == 0);
    const LayerBatch again_batch = build_layer_batch(builder, skins, people, store, [] { return true; });
    CHECK(again_batch.num_resumed == 3);
    CHECK(again_batch.bodies.parameters == whole.bodies.parameters);
    CHECK(again_batch.bodies.bodies[1].volume_vertices == whole.bodies.bodies[1].volume_vertices);
}

}  // namespace

TEST_CASE("The procedural body becomes a template with everything in its place", "[template][slow]")
{
    const ProceduralBody source;
    ProceduralParameters person;
    TemplateOptions options;
    options.prisms = 6000;
    const Template made = make_template(source.source(person), options);
    ProceduralParameters lean = person, heavy = person;
    lean.mass_kg = 19.0 * lean.stature_m * lean.stature_m;
    heavy.mass_kg = 33.0 * heavy.stature_m * heavy.stature_m;
    check_made(made, source.evaluate(person), source.evaluate(lean), source.evaluate(heavy));

    // Equal stature and mass: more muscle is more muscle inside and less fat.
    ProceduralParameters strong = person, soft = person;
    strong.mass_kg = soft.mass_kg = 27.0 * person.stature_m * person.stature_m;
    strong.muscularity = 0.95;
    soft.muscularity = 0.05;
    LayerReport strong_report, soft_report;
    build_layers(made, skin_on_template(made, source.evaluate(strong), "strong"), {0.5, 30.0}, 0.05, &strong_report);
    build_layers(made, skin_on_template(made, source.evaluate(soft), "soft"), {0.5, 30.0}, 0.05, &soft_report);
    CHECK(strong_report.muscle_layer_litre > 1.05 * soft_report.muscle_layer_litre);
    CHECK(strong_report.fat_layer_litre < soft_report.fat_layer_litre);

    // An open skin is refused in one sentence.
    TemplateSource open = source.source(person);
    open.surface.triangles.conservativeResize(open.surface.triangles.rows() - 1, 3);
    CHECK_THROWS_AS(make_template(open, options), InputError);
}

TEST_CASE("MakeHuman's body with real bones and muscles becomes a template", "[makehuman][slow]")
{
    if (test::data_folder().empty()) return;
    const MakeHuman body(test::data_folder() + "/makehuman");
    MakeHumanParameters man;
    man.sex = 1.0;
    TemplateOptions options;
    options.prisms = 6000;
    const Template made =
        make_template(anatomy_source(body, test::data_folder() + "/bodyparts3d", man).source, options);
    CHECK(made.anatomy_parts.size() > 500);
    MakeHumanParameters lean = man, heavy = man;
    lean.weight = 0.2;
    heavy.weight = 0.9;
    heavy.muscle = 0.2;
    check_made(made, body.evaluate(man), body.evaluate(lean), body.evaluate(heavy));
}
