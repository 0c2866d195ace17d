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
#include <map>

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

tinygltf::Model load_glb(const std::string& path)
{
    tinygltf::Model model;
    std::string error, warning;
    REQUIRE(tinygltf::TinyGLTF().LoadBinaryFromFile(&model, &error, &warning, path));
    CHECK(error.empty());
    CHECK(warning.empty());
    return model;
}

std::vector<float> floats_of(const tinygltf::Model& model, int accessor_idx)
{
    const tinygltf::Accessor& accessor = model.accessors[accessor_idx];
    std::vector<float> values(accessor.count *
                              std::size_t(tinygltf::GetNumComponentsInType(std::uint32_t(accessor.type))));
    std::memcpy(values.data(), model.buffers[0].data.data() + model.bufferViews[accessor.bufferView].byteOffset,
                4 * values.size());
    return values;
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
    const tinygltf::Model model = load_glb(folder.file("a.glb"));
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

TEST_CASE("Several frames become one animation: rigid meshes turn their node, others have a morph target a frame")
{
    const test::TemporaryFolder folder;
    MeshSequence sequence = body_like(3);
    sequence.frame_rate = 10.0;
    sequence.meshes[1].group = "bones";
    sequence.meshes[1].fma_id = 9611;
    const auto before = sequence.frame;
    sequence.frame = [before](int frame_idx) {
        std::vector<MeshFrame> frames = before(frame_idx);
        frames[0].vertices(3, 0) += 0.5 * frame_idx * frame_idx;  // the skin bends
        const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.2 * frame_idx, Eigen::Vector3d(1, 2, 2) / 3.0).matrix();
        frames[1].vertices = (frames[1].vertices * turn.transpose()).eval();
        return frames;
    };
    export_meshes(folder.file("a.glb"), sequence);
    const tinygltf::Model model = load_glb(folder.file("a.glb"));
    const auto floats = [&](int accessor_idx) { return floats_of(model, accessor_idx); };
    const auto rows = [](const std::vector<float>& values) {
        return Points(Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>>(
                          values.data(), Eigen::Index(values.size() / 3), 3)
                          .cast<double>());
    };
    const auto node_of = [&](const std::string& name) {
        return int(std::find_if(model.nodes.begin(), model.nodes.end(),
                                [&](const tinygltf::Node& node) { return node.name == name && node.mesh >= 0; }) -
                   model.nodes.begin());
    };
    REQUIRE(model.animations.size() == 1);
    const tinygltf::Animation& animation = model.animations[0];
    const auto channel = [&](int node, const std::string& path) -> const tinygltf::AnimationSampler& {
        for (const tinygltf::AnimationChannel& entry : animation.channels)
            if (entry.target_node == node && entry.target_path == path) return animation.samplers[entry.sampler];
        FAIL("no " << path);
        return animation.samplers[0];
    };

    const int bones = node_of("bones");
    CHECK(model.nodes[bones].extras.Get("fma_id").GetNumberAsInt() == 9611);
    const auto group = std::find_if(model.nodes.begin(), model.nodes.end(),
                                    [](const tinygltf::Node& node) { return node.name == "bones" && node.mesh < 0; });
    REQUIRE(group != model.nodes.end());
    CHECK(group->children == std::vector<int>{bones});
    CHECK(std::count(model.scenes[0].nodes.begin(), model.scenes[0].nodes.end(), bones) == 0);
    const std::vector<float> times = floats(channel(bones, "rotation").input);
    CHECK(times == std::vector<float>{0.0f, 0.1f, 0.2f});
    const std::vector<float> turns = floats(channel(bones, "rotation").output);
    const std::vector<float> shifts = floats(channel(bones, "translation").output);
    const tinygltf::Primitive& bone = model.meshes[model.nodes[bones].mesh].primitives[0];
    CHECK(bone.targets.empty());
    const Points rest = rows(floats(bone.attributes.at("POSITION")));
    for (int f = 0; f < 3; ++f) {
        const Eigen::Quaterniond turn(turns[4 * f + 3], turns[4 * f], turns[4 * f + 1], turns[4 * f + 2]);
        const Eigen::Vector3d shift(shifts[3 * f], shifts[3 * f + 1], shifts[3 * f + 2]);
        const Points moved = (rest * turn.matrix().transpose()).rowwise() + shift.transpose();
        CHECK((moved - sequence.frame(f)[1].vertices).cwiseAbs().maxCoeff() < 1e-5);
        if (f > 0) {
            float along = 0.0f;
            for (int k = 0; k < 4; ++k) along += turns[4 * f + k] * turns[4 * f - 4 + k];
            CHECK(along > 0.0f);
        }
    }

    const int skin = node_of("skin");
    const tinygltf::Mesh& mesh = model.meshes[model.nodes[skin].mesh];
    REQUIRE(mesh.primitives[0].targets.size() == 2);
    CHECK(mesh.weights == std::vector<double>{0.0, 0.0});
    CHECK(floats(channel(skin, "weights").output) == std::vector<float>{0, 0, 1, 0, 0, 1});
    for (int f = 1; f < 3; ++f) {
        const std::map<std::string, int>& target = mesh.primitives[0].targets[f - 1];
        const Points moved =
            rows(floats(mesh.primitives[0].attributes.at("POSITION"))) + rows(floats(target.at("POSITION")));
        CHECK((moved - sequence.frame(f)[0].vertices).cwiseAbs().maxCoeff() < 1e-6);
        const Points normals =
            rows(floats(mesh.primitives[0].attributes.at("NORMAL"))) + rows(floats(target.at("NORMAL")));
        CHECK(normals.rowwise().norm().isApproxToConstant(1.0, 1e-5));
    }
    CHECK(exported_files("a.glb", 3) == std::vector<std::string>{"a.glb"});
    CHECK(exported_files("a_{}.glb", 2) == std::vector<std::string>{"a_0.glb", "a_1.glb"});
}

TEST_CASE("A rig becomes a skin of joints; clips become animations, each with its own frames")
{
    const test::TemporaryFolder folder;
    MeshSequence sequence = test::rig_like(5);
    sequence.clips = {{"walk", 0, 3, 10.0}, {"run", 3, 5, 20.0}};
    export_meshes(folder.file("a.glb"), sequence);
    const tinygltf::Model model = load_glb(folder.file("a.glb"));
    const auto floats = [&](int accessor_idx) { return floats_of(model, accessor_idx); };
    REQUIRE(model.skins.size() == 1);
    const std::vector<int>& joints = model.skins[0].joints;
    REQUIRE(joints.size() == 2);
    CHECK(model.nodes[joints[0]].name == "pelvis");
    CHECK(model.nodes[joints[0]].children == std::vector<int>{joints[1]});
    CHECK(model.nodes[joints[1]].translation == std::vector<double>{0, 0.5, 0});
    CHECK(floats(model.skins[0].inverseBindMatrices)[16 + 13] == -0.75f);
    const auto skin =
        std::find_if(model.nodes.begin(), model.nodes.end(), [](const tinygltf::Node& node) { return node.skin == 0; });
    REQUIRE(skin != model.nodes.end());
    CHECK(skin->name == "skin");
    const tinygltf::Primitive& primitive = model.meshes[skin->mesh].primitives[0];
    CHECK(primitive.attributes.count("JOINTS_0") == 1);
    CHECK(primitive.attributes.count("JOINTS_1") == 0);
    CHECK(floats(primitive.attributes.at("WEIGHTS_0"))[4] == 0.75f);
    CHECK(primitive.targets.size() == 1);

    REQUIRE(model.animations.size() == 2);
    CHECK(model.animations[1].name == "run");
    int found = 0;
    for (const tinygltf::AnimationChannel& channel : model.animations[1].channels) {
        const tinygltf::AnimationSampler& sampler = model.animations[1].samplers[channel.sampler];
        CHECK(floats(sampler.input) == std::vector<float>{0.0f, 0.05f});
        if (channel.target_path == "rotation" && channel.target_node == joints[1]) {
            CHECK(floats(sampler.output)[2] == Approx(std::sin(0.75)));
            ++found;
        }
        if (channel.target_path == "translation" && channel.target_node == joints[0]) {
            CHECK(floats(sampler.output)[1] == 0.75f);
            ++found;
        }
        // The bones beside move by five frames' targets, or as a whole.
        if (channel.target_path == "weights" && channel.target_node != int(skin - model.nodes.begin()))
            CHECK(floats(sampler.output).size() == 2 * 4);
    }
    CHECK(found == 2);
}
