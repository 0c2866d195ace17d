// SPDX-License-Identifier: Apache-2.0
#include "ndg/runtime/runtime_model.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "support/random_network.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <cstring>

using namespace ndg;

namespace {

Template small_tube()
{
    Template tube = test::tube_template(5, 6);
    tube.file_sha256 = "tube";
    return tube;
}

std::string error_of(const std::string& path)
{
    try {
        RuntimeModel{path};
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

}  // namespace

TEST_CASE("A runtime model is mapped as it was written")
{
    const Template tube = small_tube();
    test::RandomNetwork network;
    network.num_parts = 3;
    network.output_basis = 7;
    network.weights = {WeightStorage::int8, WeightStorage::bfloat16};
    network.traits.posing = test::bending;
    network.traits.shape = false;
    const test::TemporaryFolder folder;
    const std::string path = folder.file("model.ndg");
    test::write_random_network(path, tube, network);
    const RuntimeDescription expected = test::describe_random_network(tube, network);
    const BlockSource blocks = test::random_blocks(expected, network);
    const RuntimeModel model(path);
    CHECK(model.template_sha256 == "tube");
    CHECK(model.traits.posing.bone_wrap == BoneWrap::lbs);
    CHECK_FALSE(model.traits.shape);
    CHECK(model.traits.rotation);
    CHECK(model.joint_names == expected.joint_names);
    CHECK(model.visible_joints == expected.visible_joints);
    CHECK(model.shape_space.mean == expected.shape_space.mean);
    CHECK(model.shape_space.components == expected.shape_space.components);
    CHECK(model.shape_space.standard_deviations == expected.shape_space.standard_deviations);
    CHECK(model.num_prisms() == tube.num_prisms());
    REQUIRE(model.parts.size() == 3);
    for (std::size_t p = 0; p < 3; ++p) {
        CHECK(model.parts[p].inputs == expected.parts[p].inputs);
        CHECK(model.parts[p].prisms == expected.parts[p].prisms);
        REQUIRE(model.parts[p].layers.size() == 4);
        for (std::size_t i = 0; i < 4; ++i) {
            const RuntimeLayer& layer = model.parts[p].layers[i];
            CHECK(layer.norm_weight == expected.parts[p].layers[i].norm_weight);
            CHECK(reinterpret_cast<std::uintptr_t>(layer.blocks) % 4096 == 0);
            const std::size_t block_bytes = weight_block_bytes(layer.storage, layer.num_columns);
            const int block = num_weight_blocks(layer.num_rows) - 1;
            std::vector<float> rows(std::size_t(weight_rows) * layer.num_columns, 0.0F), biases(weight_rows, 0.0F);
            blocks(int(p), int(i), block, rows.data(), biases.data());
            std::vector<std::byte> packed(block_bytes);
            pack_weight_block(layer.storage, layer.num_columns, rows.data(), biases.data(), packed.data());
            CHECK(std::memcmp(packed.data(), layer.blocks + std::size_t(block) * block_bytes, block_bytes) == 0);
        }
    }
}

TEST_CASE("A damaged runtime model is refused, naming the file")
{
    const test::TemporaryFolder folder;
    const std::string path = folder.file("model.ndg"), damaged = folder.file("damaged.ndg");
    test::write_random_network(path, small_tube(), {});
    const std::string whole = read_file(path);
    REQUIRE(error_of(path).empty());
    CHECK_THAT(error_of(folder.file("missing.ndg")), Catch::Contains("missing.ndg") && Catch::Contains("opened"));
    for (const std::size_t length : {std::size_t(5), std::size_t(40), whole.size() / 2, whole.size() - 4096}) {
        write_file(damaged, whole.substr(0, length));
        INFO(length);
        CHECK_THAT(error_of(damaged), Catch::Contains("damaged.ndg"));
    }
    std::string other = whole;
    other[0] = 'x';
    write_file(damaged, other);
    CHECK_THAT(error_of(damaged), Catch::Contains("no runtime model"));
    other = whole;
    other[12] = 2;
    write_file(damaged, other);
    CHECK_THAT(error_of(damaged), Catch::Contains("version 2"));
    const std::size_t prisms = whole.find("\"prisms\":[0,1,");
    REQUIRE(prisms != std::string::npos);
    other = whole;
    other[prisms + 12] = '0';
    write_file(damaged, other);
    CHECK_THAT(error_of(damaged), Catch::Contains("prism 0"));
    other = whole;
    other[prisms] = '}';
    write_file(damaged, other);
    CHECK_THAT(error_of(damaged), Catch::Contains("head is damaged"));
}
