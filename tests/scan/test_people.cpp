// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/scan/people.h"
#include "support/support.h"

#include <catch2/catch.hpp>

using namespace ndg;

TEST_CASE("people are written as they are read")
{
    const test::TemporaryFolder folder;
    SkinSet bodies;
    bodies.parameter_names = {"stature_m", "age_years", "sex"};
    bodies.bodies.resize(2);
    bodies.bodies[0].name = "a";
    bodies.bodies[1].name = "b";
    bodies.parameters.resize(2, 3);
    bodies.parameters << 1.7, 33.0, 0.0, 1.8, 44.0, 1.0;
    write_people(folder.file("people.json"), bodies, "skins");
    const People people = read_people(folder.file("people.json"));
    REQUIRE(people.size() == 2);
    CHECK(people.at("a").sex == 0.0);
    CHECK(people.at("a").age_years == 33.0);
    CHECK(people.at("b").sex == 1.0);
    // Children are not adults.
    write_file(folder.file("child.json"), "{\"c\": {\"age_years\": 9}}");
    CHECK_THROWS_AS(read_people(folder.file("child.json")), InputError);
    bodies.parameter_names[2] = "gender";
    CHECK_THROWS_AS(write_people(folder.file("people.json"), bodies, "skins"), InputError);
}
