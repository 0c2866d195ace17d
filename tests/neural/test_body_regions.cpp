// SPDX-License-Identifier: Apache-2.0
// Which joint rules what, and what its network may see.
#include "ndg/neural/body_regions.h"

#include "ndg/core/error.h"
#include "synthetic.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <set>

using namespace ndg;
using namespace ndg::test;

namespace {

/// Elements of which each belongs to one joint alone.
SkinningWeights whole_weights(const std::vector<std::string>& joints)
{
    RowMatrix dense = RowMatrix::Zero(static_cast<Eigen::Index>(joints.size()), num_standard_joints);
    for (std::size_t i = 0; i < joints.size(); ++i) dense(i, standard_skeleton().joint(joints[i])) = 1;
    return sparsify_weights(dense);
}

const BodyRegion& region_of(const std::vector<BodyRegion>& regions, const std::string& joint)
{
    const auto found = std::find_if(regions.begin(), regions.end(), [&](const BodyRegion& region) {
        return region.joint == standard_skeleton().joint(joint);
    });
    REQUIRE(found != regions.end());
    return *found;
}

bool sees(const BodyRegion& region, const std::string& joint)
{
    return std::count(region.seen_joints.begin(), region.seen_joints.end(), standard_skeleton().joint(joint)) == 1;
}

}  // namespace

TEST_CASE("a region is what one joint rules, and sees two steps up, down and aside")
{
    const std::vector<BodyRegion> regions = find_body_regions(
        standard_skeleton(), whole_weights({"left_thigh", "pelvis", "left_thigh", "right_forearm"}), 2);
    REQUIRE(regions.size() == 3);
    const BodyRegion &thigh = region_of(regions, "left_thigh"), &forearm = region_of(regions, "right_forearm");
    CHECK(thigh.elements == std::vector<int>{0, 2});
    CHECK(region_of(regions, "pelvis").elements == std::vector<int>{1});
    for (const char* joint : {"left_thigh", "pelvis", "left_shin", "left_foot", "right_thigh", "spine_1"})
        CHECK(sees(thigh, joint));
    for (const char* joint : {"right_shin", "spine_2", "left_toes", "left_upper_arm"}) CHECK(!sees(thigh, joint));
    for (const char* joint : {"right_forearm", "right_upper_arm", "right_clavicle", "right_hand"})
        CHECK(sees(forearm, joint));
    for (const char* joint : {"left_forearm", "left_upper_arm", "spine_5", "pelvis"}) CHECK(!sees(forearm, joint));
}

TEST_CASE("a region of few elements goes to the nearest one, above before below")
{
    std::vector<std::string> joints(1000, "neck_1");
    joints.insert(joints.end(), 1000, "left_thigh");
    joints.insert(joints.end(), {"head", "left_shin", "spine_5"});
    const std::vector<BodyRegion> regions = find_body_regions(standard_skeleton(), whole_weights(joints), 1);
    REQUIRE(regions.size() == 2);
    const std::vector<int>& neck = region_of(regions, "neck_1").elements;
    CHECK(neck.size() == 1002);
    CHECK(std::count(neck.begin(), neck.end(), 2000) == 1);
    CHECK(std::count(neck.begin(), neck.end(), 2002) == 1);
    CHECK(region_of(regions, "left_thigh").elements.back() == 2001);
}

TEST_CASE("columns hold every output once, and inputs of near joints and the shape")
{
    Synthetic s = make_synthetic(8, 2);
    s.tube = symmetric_tube_template(9);
    s.tube.file_sha256 = "tube";
    const Body wide = scaled_tube(s.tube, 1.2, 1.0);
    s.shape_space = fit_shape_space({&s.tube.rest.volume_vertices, &wide.volume_vertices}, 2, 1.0);
    for (const char* output_space : {"residuals", "vertex-offsets"}) {
        NetworkOptions options = small_network();
        options.output_space = output_space;
        const NeuralModel model(options, s.shape_space, s.tube, 1);
        const std::vector<NetworkColumns> columns =
            regional_columns(s.tube, model.input_space(), model.output_space(), 1);
        CHECK(columns.size() >= 4);
        std::vector<int> outputs;
        for (const NetworkColumns& of_region : columns) {
            CHECK(std::is_sorted(of_region.outputs.begin(), of_region.outputs.end()));
            outputs.insert(outputs.end(), of_region.outputs.begin(), of_region.outputs.end());
            CHECK(of_region.inputs.back() == model.input_space().width() - 1);
            for (const int input : of_region.inputs)
                CHECK((input >= 9 * num_standard_joints || model.input_space().visible_joints()[input / 9] == 1));
        }
        CHECK(static_cast<int>(outputs.size()) == model.output_space().width());
        CHECK(std::set<int>(outputs.begin(), outputs.end()).size() == outputs.size());
    }
    NetworkOptions whole_gradients = small_network();
    whole_gradients.rotation = false;
    whole_gradients.region_reach = 1;
    CHECK_THROWS_WITH(NeuralModel(whole_gradients, s.shape_space, s.tube, 1),
                      Catch::Contains("residuals and offsets only"));
}
