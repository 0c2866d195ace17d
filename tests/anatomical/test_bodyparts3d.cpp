// SPDX-License-Identifier: Apache-2.0
#include "ndg/anatomical/bodyparts3d.h"
#include "ndg/core/error.h"

#include <catch2/catch.hpp>

using namespace ndg;

TEST_CASE("File names of BodyParts3D say part, FMA id and side")
{
    const BodyPartName femur = parse_body_part_name("FJ838_BP63016_FMA24475_Left_femur.glb");
    CHECK(femur.name == "Left femur");
    CHECK(femur.fma_id == 24475);
    CHECK(femur.side == BodySide::left);
    CHECK(parse_body_part_name("FJ416_BP63675_FMA42398_Set_of_lumbricals_of_right_hand.glb").side == BodySide::right);
    CHECK(parse_body_part_name("FJ829_BP62535_FMA13295_Diaphragm.glb").side == BodySide::middle);
    CHECK_THROWS_AS(parse_body_part_name("femur.glb"), InputError);
    CHECK_THROWS_AS(parse_body_part_name("FJ1_BP2_FMAx_Femur.glb"), InputError);
}
