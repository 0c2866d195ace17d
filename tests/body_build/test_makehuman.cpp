// SPDX-License-Identifier: Apache-2.0
// The real body: MakeHuman's surface, template and layers. Skips without a data folder.
#include "ndg/body_source/body_sampling.h"
#include "ndg/body_build/layers.h"
#include "ndg/body_build/make_template.h"
#include "ndg/body_source/makehuman.h"
#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"
#include "support/support.h"

#include <catch2/catch.hpp>

using namespace ndg;
using Catch::Matchers::Contains;

TEST_CASE("MakeHuman's sliders do what they say", "[makehuman]")
{
    if (test::data_folder().empty()) return;
    const MakeHuman source(test::data_folder() + "/makehuman");
    const ParametricSurface middle = source.evaluate({});
    CHECK(middle.vertices.rows() == 13380);
    CHECK(middle.triangles.rows() == 26756);
    CHECK(closed_surface_defect(middle.vertices, middle.triangles).empty());
    CHECK(middle.vertices.col(1).minCoeff() == Approx(0.0).margin(1e-12));
    CHECK(stature(middle.vertices) > 1.5);
    CHECK(stature(middle.vertices) < 1.85);

    const auto with = [&](auto change) {
        MakeHumanParameters p;
        change(p);
        const ParametricSurface s = source.evaluate(p);
        return std::make_pair(stature(s.vertices), body_density * enclosed_volume(s.vertices, s.triangles));
    };
    const auto base = with([](MakeHumanParameters&) {});
    CHECK(with([](MakeHumanParameters& p) { p.height = 0.9; }).first > base.first + 0.1);
    CHECK(with([](MakeHumanParameters& p) { p.height = 0.1; }).first < base.first - 0.1);
    CHECK(with([](MakeHumanParameters& p) { p.weight = 0.9; }).second > 1.05 * base.second);
    CHECK(with([](MakeHumanParameters& p) { p.weight = 0.1; }).second < 0.95 * base.second);
    const auto heavy = with([](MakeHumanParameters& p) {
        p.weight = 0.9;
        p.muscle = 0.2;
    });
    CHECK(heavy.second > 1.25 * base.second);
    CHECK(with([](MakeHumanParameters& p) { p.sex = 1.0; }).first >
          with([](MakeHumanParameters& p) { p.sex = 0.0; }).first);
    CHECK_THROWS_WITH(with([](MakeHumanParameters& p) { p.age = 0.2; }), Contains("age is 0.2"));

    // Joints: left is +x, the hand below the shoulder in the A pose, symmetric to a centimetre.
    const Skeleton& skeleton = standard_skeleton();
    const auto at = [&](const char* name) -> Eigen::RowVector3d {
        return middle.joint_positions.row(skeleton.joint(name));
    };
    CHECK(at("left_hand").x() > 0.3);
    CHECK(at("left_hand").y() < at("left_upper_arm").y());
    CHECK(at("left_toes").z() > at("left_foot").z());
    CHECK((at("left_shin") - at("right_shin").cwiseProduct(Eigen::RowVector3d(-1, 1, 1))).norm() < 0.01);

    const RowMatrix& weights = source.weights();
    CHECK((weights.rowwise().sum().array() - 1.0).abs().maxCoeff() < 1e-9);
    CHECK((weights.array() > 1e-4).cast<int>().rowwise().sum().maxCoeff() <= 16);
}

TEST_CASE("template and bodies of MakeHuman are valid everywhere", "[makehuman]")
{
    if (test::data_folder().empty()) return;
    const MakeHuman source(test::data_folder() + "/makehuman");
    TemplateOptions options;
    options.target_edge_length = 0.032;
    const Template made = make_template(source.evaluate({}), source.weights(), options);
    CHECK(made.num_prisms() > 2000);
    CHECK(check_prisms(made.rest.volume_vertices, made.prisms).num_invalid == 0);
    CHECK(closed_surface_defect(made.rest.skin_vertices, made.skin_triangles).empty());
    CHECK((made.skin_weights.weights.rowwise().sum().array() - 1.0).abs().maxCoeff() < 1e-9);

    // The layers lie inside each other: no muscle or bone wrap vertex outside the skin.
    const int n = made.num_wrap_vertices();
    const Eigen::VectorXd winding =
        winding_numbers(made.rest.skin_vertices, made.skin_triangles, made.rest.volume_vertices.topRows(2 * n));
    CHECK(winding.minCoeff() > 0.5);

    // Every bone vertex lies in an element or within half a millimetre of one.
    for (const double distance : made.embedding.distances) CHECK(distance < 5e-4);
    CHECK((apply_embedding(made.embedding, made.rest.volume_vertices, made.rest.interior_vertices) -
           made.anatomy_vertices)
              .rowwise()
              .norm()
              .maxCoeff() < 5.1e-4);

    // The template's own skin comes back from the source; a heavier and a leaner person get valid layers, and more fat.
    CHECK((skin_on_template(made, source.evaluate({}), "x").skin_vertices - made.rest.skin_vertices).norm() < 1e-9);
    LayerReport lean, heavy;
    MakeHumanParameters p;
    p.weight = 0.2;
    const Person person{0.5, 40.0};
    const Body lean_body = build_layers(made, skin_on_template(made, source.evaluate(p), "lean"), person, 0.05, &lean);
    p.weight = 0.9;
    p.muscle = 0.2;
    const Body heavy_body =
        build_layers(made, skin_on_template(made, source.evaluate(p), "heavy"), person, 0.05, &heavy);
    CHECK(check_prisms(lean_body.volume_vertices, made.prisms).num_invalid == 0);
    CHECK(check_prisms(heavy_body.volume_vertices, made.prisms).num_invalid == 0);
    CHECK(heavy.bmi > lean.bmi + 4.0);
    CHECK(heavy.fat_layer_litre > 1.3 * lean.fat_layer_litre);

    // An open skin is refused in one sentence.
    ParametricSurface open = source.evaluate({});
    open.triangles.conservativeResize(open.triangles.rows() - 1, 3);
    CHECK_THROWS_WITH(make_template(open, source.weights(), options), Contains("the skin cannot be used"));
}
