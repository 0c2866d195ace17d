// SPDX-License-Identifier: Apache-2.0
#include "export/sequences.h"
#include "ndg/core/file.h"
#include "ndg/export/export_meshes.h"
#include "support/support.h"

#include <tiny_gltf.h>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstring>

using namespace ndg;
using ndg::test::body_like;

namespace {

std::uint32_t word(const std::string& bytes, std::size_t offset)
{
    std::uint32_t value = 0;
    REQUIRE(offset + 4 <= bytes.size());
    std::memcpy(&value, bytes.data() + offset, 4);
    return value;
}

}  // namespace

TEST_CASE("The container is a version 2 GLB of a padded JSON chunk and a binary chunk")
{
    const test::TemporaryFolder folder;
    export_meshes(folder.file("a.glb"), body_like());
    const std::string bytes = read_file(folder.file("a.glb"));
    CHECK(bytes.substr(0, 4) == "glTF");
    CHECK(word(bytes, 4) == 2);
    CHECK(word(bytes, 8) == bytes.size());
    const std::size_t json_length = word(bytes, 12);
    CHECK(json_length % 4 == 0);
    CHECK(bytes.substr(16, 4) == "JSON");
    const nlohmann::json scene = nlohmann::json::parse(bytes.substr(20, json_length));
    CHECK(scene["asset"]["version"] == "2.0");
    CHECK(scene["asset"]["copyright"] == "CC0 1.0");
    CHECK(scene["nodes"].size() == 3);
    const std::size_t binary = 20 + json_length;
    const std::size_t binary_length = word(bytes, binary);
    CHECK(std::memcmp(bytes.data() + binary + 4, "BIN\0", 4) == 0);
    CHECK(binary + 8 + binary_length == bytes.size());
    CHECK(scene["buffers"][0]["byteLength"].get<std::size_t>() <= binary_length);
    CHECK_FALSE(scene["buffers"][0].contains("uri"));
}

TEST_CASE("Nodes, accessors and materials survive reading by tinygltf")
{
    const test::TemporaryFolder folder;
    const MeshSequence sequence = body_like();
    const std::vector<MeshFrame> frames = sequence.frame(0);
    export_meshes(folder.file("a.glb"), sequence);
    tinygltf::Model model;
    std::string error, warning;
    REQUIRE(tinygltf::TinyGLTF().LoadBinaryFromFile(&model, &error, &warning, folder.file("a.glb")));
    CHECK(error.empty());
    CHECK(warning.empty());
    REQUIRE(model.nodes.size() == 3);
    // Translucent last.
    CHECK(model.nodes[0].name == "bones");
    CHECK(model.nodes[1].name == "muscle_wrap");
    CHECK(model.nodes[2].name == "skin");
    CHECK(model.scenes[std::size_t(model.defaultScene)].nodes.size() == 3);

    for (const tinygltf::Node& node : model.nodes) {
        INFO(node.name);
        const auto mesh = std::find_if(sequence.meshes.begin(), sequence.meshes.end(),
                                       [&](const ExportedMesh& candidate) { return candidate.name == node.name; });
        REQUIRE(mesh != sequence.meshes.end());
        const MeshFrame& frame = frames[mesh - sequence.meshes.begin()];
        const tinygltf::Primitive& primitive = model.meshes[std::size_t(node.mesh)].primitives.at(0);
        const tinygltf::Accessor& positions = model.accessors[std::size_t(primitive.attributes.at("POSITION"))];
        const tinygltf::Accessor& normals = model.accessors[std::size_t(primitive.attributes.at("NORMAL"))];
        const tinygltf::Accessor& indices = model.accessors[std::size_t(primitive.indices)];
        CHECK(positions.count == std::size_t(frame.vertices.rows()));
        CHECK(normals.count == positions.count);
        CHECK(indices.count == std::size_t(mesh->triangles.size()));
        CHECK(indices.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT);
        for (int k = 0; k < 3; ++k) {
            CHECK(positions.minValues.at(std::size_t(k)) == Approx(frame.vertices.col(k).minCoeff()).epsilon(1e-6));
            CHECK(positions.maxValues.at(std::size_t(k)) == Approx(frame.vertices.col(k).maxCoeff()).epsilon(1e-6));
        }
        const auto data = [&](const tinygltf::Accessor& accessor) {
            const tinygltf::BufferView& view = model.bufferViews[std::size_t(accessor.bufferView)];
            CHECK((view.byteOffset + accessor.byteOffset) % 4 == 0);
            return model.buffers[0].data.data() + view.byteOffset + accessor.byteOffset;
        };
        float position[3], normal[3];
        std::uint32_t index = 0;
        std::memcpy(position, data(positions) + 3 * 3 * sizeof(float), sizeof position);  // vertex 3
        for (int k = 0; k < 3; ++k) CHECK(position[k] == float(frame.vertices(3, k)));
        for (std::size_t i = 0; i < normals.count; ++i) {
            std::memcpy(normal, data(normals) + 3 * i * sizeof(float), sizeof normal);
            CHECK(std::hypot(normal[0], normal[1], normal[2]) == Approx(1.0).margin(1e-5));
        }
        std::memcpy(&index, data(indices) + 4 * sizeof(std::uint32_t), sizeof index);
        CHECK(int(index) == mesh->triangles(1, 1));

        const tinygltf::Material& material = model.materials[std::size_t(primitive.material)];
        CHECK(material.name == node.name);
        CHECK(material.alphaMode == (mesh->opacity < 1 ? "BLEND" : "OPAQUE"));
        CHECK(material.pbrMetallicRoughness.baseColorFactor.at(3) == Approx(mesh->opacity));
        CHECK(primitive.attributes.count("COLOR_0") == std::size_t(frame.colours.rows() > 0 ? 1 : 0));
    }
}

TEST_CASE("The same meshes give the same bytes")
{
    const test::TemporaryFolder folder;
    export_meshes(folder.file("a.glb"), body_like());
    export_meshes(folder.file("b.glb"), body_like());
    CHECK(read_file(folder.file("a.glb")) == read_file(folder.file("b.glb")));
}
