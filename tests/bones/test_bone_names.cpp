// SPDX-License-Identifier: Apache-2.0
#include "ndg/bones/bone_names.h"

#include <catch2/catch.hpp>

using namespace ndg;

namespace {

BoneName name(const std::string& text, BodySide side = BodySide::middle)
{
    AnatomyPart part;
    part.name = text;
    part.side = side;
    return name_bone(part, standard_skeleton());
}

std::string joint_of(const std::string& text, BodySide side = BodySide::middle)
{
    const BoneName bone = name(text, side);
    return bone.kind == BoneKind::joint ? standard_skeleton().joint_names[bone.joint] : "";
}

}  // namespace

TEST_CASE("Vertebrae, disks, ribs and their cartilages are numbered")
{
    const auto is = [](const BoneName& bone, BoneKind kind, int number) {
        return bone.kind == kind && bone.number == number;
    };
    CHECK(is(name("Fifth lumbar vertebra"), BoneKind::vertebra, 0));
    CHECK(is(name("First lumbar vertebra"), BoneKind::vertebra, 4));
    CHECK(is(name("Twelfth thoracic vertebra"), BoneKind::vertebra, thoracic_vertebra(12)));
    CHECK(thoracic_vertebra(12) == 5);
    CHECK(is(name("First thoracic vertebra"), BoneKind::vertebra, 16));
    CHECK(is(name("Seventh cervical vertebra"), BoneKind::vertebra, 17));
    CHECK(is(name("Axis"), BoneKind::vertebra, 22));
    CHECK(is(name("Atlas"), BoneKind::vertebra, 23));
    CHECK(is(name("Intervertebral disk of third lumbar vertebra"), BoneKind::disk, 2));
    CHECK(is(name("Intervertebral disk of axis"), BoneKind::disk, 22));
    CHECK(is(name("Left eleventh rib", BodySide::left), BoneKind::rib, 11));
    CHECK(is(name("Right second costal cartilage", BodySide::right), BoneKind::cartilage, 2));
}

TEST_CASE("Other bones move with a joint of their side or by a rule of their own")
{
    CHECK(joint_of("Skull without mandible") == "head");
    CHECK(joint_of("Left inferior nasal concha", BodySide::left) == "head");
    CHECK(joint_of("Mandible") == "jaw");
    CHECK(joint_of("Right hip bone", BodySide::right) == "pelvis");
    CHECK(joint_of("Left humerus", BodySide::left) == "left_upper_arm");
    CHECK(joint_of("Right capitate", BodySide::right) == "right_hand");
    CHECK(joint_of("Left third metacarpal bone", BodySide::left) == "left_hand");
    CHECK(joint_of("Left first metacarpal bone", BodySide::left) == "left_thumb_1");
    CHECK(joint_of("Distal phalanx of left thumb", BodySide::left) == "left_thumb_3");
    CHECK(joint_of("Middle phalanx of right index finger", BodySide::right) == "right_index_2");
    CHECK(joint_of("Distal phalanx of left middle finger", BodySide::left) == "left_middle_3");
    CHECK(joint_of("Proximal phalanx of left little finger", BodySide::left) == "left_pinky_1");
    CHECK(joint_of("Proximal phalanx of left big toe", BodySide::left) == "left_toes");
    CHECK(joint_of("Navicular bone of right foot", BodySide::right) == "right_foot");
    CHECK(name("Manubrium").kind == BoneKind::sternum);
    CHECK(name("Left fibula", BodySide::left).kind == BoneKind::shank);
    CHECK(name("Left patella", BodySide::left).kind == BoneKind::patella);
    CHECK(name("Left scapula", BodySide::left).kind == BoneKind::scapula);
    CHECK(name("Bone of contention").kind == BoneKind::unknown);
}
