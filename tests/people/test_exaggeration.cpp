// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/people/exaggeration.h"
#include "support/support.h"

#include <catch2/catch.hpp>

using namespace ndg;

namespace {

struct People {
    Template tube = test::tube_template();
    SkinSet skins;

    People()
    {
        for (const double breadth : {1.0, 1.2}) {
            Skin skin = tube.rest;
            skin.skin_vertices.col(1).array() -= skin.skin_vertices.col(1).minCoeff();
            skin.skin_vertices.col(0) *= breadth;
            skins.bodies.push_back(skin);
        }
        tube.rest.skin_vertices = skins.bodies[0].skin_vertices;
        skins.parameter_names = {"age_years", "stature_m"};
        skins.parameters.resize(2, 2);
        skins.parameters << 30, 1.5, 40, 1.5;
    }
};

}  // namespace

TEST_CASE_METHOD(People, "What a person differs in from the template body is exaggerated, the rest is not")
{
    const SkinSet wide = exaggerated_person(tube, skins, 1, 2.0);
    REQUIRE(wide.bodies.size() == 1);
    const Points& usual = skins.bodies[0].skin_vertices;
    CHECK((wide.bodies[0].skin_vertices.col(0) - 1.4 * usual.col(0)).norm() < 1e-12);
    CHECK((wide.bodies[0].skin_vertices.rightCols(2) - usual.rightCols(2)).norm() < 1e-12);
    CHECK(wide.parameters(0, 0) == 40);
    CHECK(wide.parameters(0, 1) == Approx(usual.col(1).maxCoeff()));
    CHECK((exaggerated_person(tube, skins, 1, 1.0).bodies[0].skin_vertices - skins.bodies[1].skin_vertices).norm() <
          1e-12);
    CHECK_THROWS_AS(exaggerated_person(tube, skins, 2, 1.5), InputError);
}
