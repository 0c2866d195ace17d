// SPDX-License-Identifier: Apache-2.0
// Joint maps for rigs whose joints have prefixes, other spellings of sides, or fewer joints.
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/retarget/joint_map.h"
#include "ndg/retarget/joint_map_names.h"
#include "support/support.h"

#include "retarget/foreign_rig.h"

#include <catch2/catch.hpp>

#include <filesystem>

using namespace ndg;
using namespace ndg::test;
using Catch::Matchers::Contains;

namespace {

/// Only the skeleton counts.
MotionClip skeleton(const std::vector<RigJoint>& rig)
{
    MotionClip clip;
    clip.name = "rig";
    for (const RigJoint& joint : rig) {
        clip.joint_names.push_back(joint.name);
        clip.parents.push_back(joint.parent.empty() ? -1 : clip.find_joint(joint.parent));
    }
    return clip;
}

std::string fitting(const MotionClip& clip)
{
    const std::optional<JointMap> map = find_joint_map(read_joint_maps(config_path("joint-maps")), clip);
    return map ? std::filesystem::path(map->path).filename().string() : "none";
}

/// "LeftForeArm" as "ForeArm" + ending.
std::string side_at_end(const std::string& name, const std::string& left, const std::string& right)
{
    if (name.rfind("Left", 0) == 0) return name.substr(4) + left;
    if (name.rfind("Right", 0) == 0) return name.substr(5) + right;
    return name;
}

}  // namespace

TEST_CASE("a rig fits its map whatever its prefix is and however it spells the sides")
{
    using Name = std::string;
    const std::vector<std::function<Name(const Name&)>> spellings = {
        [](const Name& name) { return name; },
        [](const Name& name) { return "mixamorig:" + name; },
        [](const Name& name) { return "mixamorig1:" + name; },
        [](const Name& name) { return "mixamorig_" + name; },
        [](const Name& name) { return "mixamorig12_" + name; },
        [](const Name& name) { return "scene:hero:" + name; },
        [](const Name& name) { return "DEF-" + side_at_end(name, ".L", ".R"); },
        [](const Name& name) { return side_at_end(name, "_l", "_r"); },
        [](const Name& name) { return "rig_" + side_at_end(name, "_Left", "_Right"); }};
    for (const auto& spelling : spellings) {
        const MotionClip clip = skeleton(renamed(plain_rig(), spelling));
        INFO(spelling("LeftForeArm"));
        CHECK(fitting(clip) == "mixamo.json");
        const JointMap map = find_joint_map(read_joint_maps(config_path("joint-maps")), clip).value();
        for (const RigJoint& joint : plain_rig()) {
            // Which joints of the spine ours follow is the map's affair.
            if (joint.ours.find("spine") != Name::npos || joint.ours.find("neck") != Name::npos) continue;
            REQUIRE(map.find(joint.ours) != nullptr);
            CHECK(map.find(joint.ours)->source == spelling(joint.name));
        }
        CHECK(missing_source_joint(map, clip).empty());
    }
}

TEST_CASE("fingers, toes and face may be missing, limbs may not, and a message says what does")
{
    const std::vector<JointMap> maps = read_joint_maps(config_path("joint-maps"));
    std::vector<RigJoint> rig = plain_rig();
    JointMap map = find_joint_map(maps, skeleton(rig)).value();
    CHECK(map.find("left_middle_1") == nullptr);
    CHECK(map.find("left_hand")->toward.empty());
    CHECK(map.find("left_foot")->sole);
    const auto remove = [&](const std::string& name) {
        rig.erase(std::remove_if(rig.begin(), rig.end(), [&](const RigJoint& joint) { return joint.name == name; }),
                  rig.end());
    };
    remove("LeftToeBase");
    map = find_joint_map(maps, skeleton(rig)).value();
    CHECK(map.find("left_toes") == nullptr);
    CHECK(map.find("left_foot")->toward.empty());
    CHECK_FALSE(map.find("left_foot")->sole);
    CHECK(map.find("right_foot")->sole);
    remove("LeftFoot");
    CHECK_FALSE(find_joint_map(maps, skeleton(rig)));
    const std::string nearest = nearest_joint_map(maps, skeleton(rig));
    CHECK_THAT(nearest, Contains("mixamo.json lacks \"mixamorig:LeftFoot\"") && !Contains("more"));
    CHECK_THAT(nearest_joint_map(maps, skeleton({{"a", "", ""}})), Contains("lacks \"") && Contains(" more"));
}

TEST_CASE("of several maps that fit the most specific one is taken")
{
    const TemporaryFolder folder;
    const MotionClip clip = skeleton(renamed(plain_rig(), [](const std::string& name) { return "x:" + name; }));
    const std::string legs =
        R"("pelvis": "Hips", "left_thigh": "LeftUpLeg", "left_shin": "LeftLeg", "left_foot": "LeftFoot",
           "right_thigh": "RightUpLeg", "right_shin": "RightLeg", "right_foot": "RightFoot")";
    write_file(folder.file("a.json"), "{\"joints\": {" + legs + "}}");
    write_file(folder.file("b.json"), "{\"joints\": {" + legs + ", \"head\": \"Head\"}}");
    write_file(folder.file("c.json"), "{\"joints\": {" + legs + ", \"head\": \"x:Head\"}}");
    const auto read = [&](const std::vector<std::string>& names) {
        std::vector<JointMap> maps;
        for (const std::string& name : names) maps.push_back(read_joint_map(folder.file(name)));
        return maps;
    };
    for (const auto& names :
         std::vector<std::vector<std::string>>{{"a.json", "b.json", "c.json"}, {"c.json", "b.json", "a.json"}})
        CHECK(find_joint_map(read(names), clip)->path == folder.file("c.json"));
    CHECK(find_joint_map(read({"a.json", "b.json"}), clip)->path == folder.file("b.json"));
    std::vector<JointMap> twice = read({"b.json", "b.json", "a.json"});
    CHECK_THROWS_WITH(find_joint_map(twice, clip), Contains("both fit"));
}

TEST_CASE("keys tell joints apart that differ in more than spelling")
{
    const auto keys = joint_name_keys({"Spine", "Spine1", "Spine01_2", "Spine12", "LeftArm", "RightArm", "arm"});
    for (std::size_t a = 0; a < keys.size(); ++a) {
        for (std::size_t b = 0; b < a; ++b) CHECK(keys[a] != keys[b]);
    }
    CHECK(joint_name_keys({"DEF-spine.003", "DEF-upper_arm.L", "DEF-upper_arm.R"}) ==
          joint_name_keys({"spine3", "LeftUpperArm", "RightUpperArm"}));
    // A joint that only bears the name of the rig keeps it.
    CHECK(joint_name_keys({"Bip01", "Bip01 Pelvis", "Bip01 Head", "Bip01 Neck", "Bip01 Tail"})[0] == "bip1");
}
