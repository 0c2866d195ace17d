// SPDX-License-Identifier: Apache-2.0
#include "ndg/layers/layer_batch.h"
#include "support/support.h"

#include <catch2/catch.hpp>

using namespace ndg;
using Catch::Matchers::Contains;

TEST_CASE("a skin of another tessellation is refused by name", "[build]")
{
    const Template tube = test::tube_template();
    Skin skin = tube.rest;
    skin.name = "someone";
    skin.skin_vertices.conservativeResize(5, 3);
    CHECK_THROWS_WITH(build_layers(tube, skin, {}, 0.05), Contains("someone") && Contains("5 skin vertices"));
    SkinSet skins;
    skins.parameter_names = {"sex"};
    CHECK_THROWS_WITH(people_of_skins(skins, "skins.h5", {}), Contains("skins.h5") && Contains("age_years"));
}
