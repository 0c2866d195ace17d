// SPDX-License-Identifier: Apache-2.0
// Binary glTF 2.0: one named node, mesh and material a mesh, vertex normals, translucent meshes alpha-blended and drawn
// last, vertex colours as COLOR_0, the credits as the asset's copyright and in its extras. Several frames are an
// animation: of a mesh that moves as a rigid body (a bone) its node's rotation and translation, of every other mesh a
// morph target a frame.
// A mesh on a skeleton is a skin of it, and moves by its joints.
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/provenance.h"
#include "ndg/export/gltf_parts.h"
#include "ndg/export/mesh_sequence.h"
#include "ndg/export/rigid_motions.h"
#include "ndg/geometry/triangle_mesh.h"

#include <tiny_gltf.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <numeric>
#include <sstream>

namespace ndg {
namespace {

using gltf::add_accessor;
using gltf::add_float_rows;
using gltf::add_positions;
using gltf::FloatRows;

FloatRows unit_normals(const ExportedMesh& mesh, const Points& vertices)
{
    FloatRows normals = vertex_normals(vertices, mesh.triangles).cast<float>();
    for (Eigen::Index i = 0; i < normals.rows(); ++i)
        if (normals.row(i).squaredNorm() < 0.5f) normals.row(i) << 0.0f, 1.0f, 0.0f;  // glTF asks for unit length
    return normals;
}

int add_indices(tinygltf::Model& model, const ExportedMesh& mesh)
{
    const std::vector<std::uint32_t> indices(mesh.triangles.data(), mesh.triangles.data() + mesh.triangles.size());
    return add_accessor(model, indices.data(), indices.size() * sizeof(std::uint32_t),
                        TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
                        TINYGLTF_TYPE_SCALAR, indices.size());
}

int add_colours(tinygltf::Model& model, const MeshFrame& frame)
{
    FloatRows colours = frame.colours;
    for (Eigen::Index i = 0; i < colours.size(); ++i) colours.data()[i] = linear_from_srgb(colours.data()[i]);
    return add_float_rows(model, colours);
}

tinygltf::Material make_material(const ExportedMesh& mesh, bool coloured)
{
    tinygltf::Material material;
    material.name = mesh.name;
    const Eigen::Vector3f colour = coloured ? Eigen::Vector3f(1, 1, 1) : linear_from_srgb(mesh.colour);
    material.pbrMetallicRoughness.baseColorFactor = {double(colour[0]), double(colour[1]), double(colour[2]),
                                                     double(mesh.opacity)};
    material.pbrMetallicRoughness.metallicFactor = 0.0;
    material.pbrMetallicRoughness.roughnessFactor = std::clamp(0.85 - double(mesh.gloss), 0.3, 1.0);
    material.alphaMode = mesh.opacity < 1.0f ? "BLEND" : "OPAQUE";
    material.doubleSided = mesh.two_sided;
    return material;
}

/// Adds a node to the scene, below its group where it has one.
int add_node(tinygltf::Model& model, const tinygltf::Node& node, const std::string& group)
{
    const auto add = [&](const tinygltf::Node& added) {
        model.nodes.push_back(added);
        return int(model.nodes.size()) - 1;
    };
    std::vector<int>& roots = model.scenes[0].nodes;
    if (group.empty()) {
        roots.push_back(add(node));
        return roots.back();
    }
    auto parent = std::find_if(roots.begin(), roots.end(),
                               [&](int k) { return model.nodes[k].name == group && model.nodes[k].mesh < 0; });
    if (parent == roots.end()) {
        tinygltf::Node group_node;
        group_node.name = group;
        roots.push_back(add(group_node));
        parent = roots.end() - 1;
    }
    const int index = add(node);
    model.nodes[*parent].children.push_back(index);
    return index;
}

/// Returns the mesh's node.
int add_mesh(tinygltf::Model& model, const ExportedMesh& exported, const MeshFrame& frame)
{
    const bool coloured = frame.colours.rows() > 0;
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    primitive.attributes["POSITION"] = add_positions(model, frame.vertices.cast<float>());
    primitive.attributes["NORMAL"] = add_float_rows(model, unit_normals(exported, frame.vertices));
    if (coloured) primitive.attributes["COLOR_0"] = add_colours(model, frame);
    primitive.indices = add_indices(model, exported);
    primitive.material = int(model.materials.size());
    model.materials.push_back(make_material(exported, coloured));
    tinygltf::Mesh mesh;
    mesh.name = exported.name;
    mesh.primitives.push_back(primitive);
    tinygltf::Node node;
    node.name = exported.name;
    node.mesh = int(model.meshes.size());
    if (exported.fma_id != 0)
        node.extras = tinygltf::Value(tinygltf::Value::Object{{"fma_id", tinygltf::Value(exported.fma_id)}});
    model.meshes.push_back(mesh);
    return add_node(model, node, exported.group);
}

/// A morph target a frame but the first.
void add_targets(tinygltf::Model& model, int node, const ExportedMesh& exported, const std::vector<Points>& vertices)
{
    tinygltf::Mesh& mesh = model.meshes[model.nodes[node].mesh];
    const FloatRows normals = unit_normals(exported, vertices[0]);
    for (std::size_t f = 1; f < vertices.size(); ++f)
        mesh.primitives[0].targets.push_back(
            {{"POSITION", add_positions(model, (vertices[f] - vertices[0]).cast<float>())},
             {"NORMAL", add_float_rows(model, unit_normals(exported, vertices[f]) - normals)}});
    mesh.weights.assign(vertices.size() - 1, 0.0);
}

/// What moves one node over all frames.
struct MovingNode {
    int node = -1;
    std::vector<Eigen::Quaterniond> rotations;  ///< of a rigid body
    Points translations;
    int num_targets = 0;  ///< of anything else
};

MovingNode add_motion(tinygltf::Model& model, int node, const ExportedMesh& mesh, const std::vector<Points>& vertices)
{
    MovingNode moving;
    moving.node = node;
    const std::optional<std::vector<Eigen::Isometry3d>> motions = rigid_motions(vertices);
    if (!motions) {
        add_targets(model, node, mesh, vertices);
        moving.num_targets = int(vertices.size()) - 1;
        return moving;
    }
    moving.translations.resize(Eigen::Index(motions->size()), 3);
    for (std::size_t f = 0; f < motions->size(); ++f) {
        moving.rotations.emplace_back((*motions)[f].linear());
        moving.translations.row(Eigen::Index(f)) = (*motions)[f].translation().transpose();
    }
    return moving;
}

tinygltf::Asset asset_of(const MeshSequence& sequence)
{
    tinygltf::Asset asset;
    asset.version = "2.0";
    asset.generator = "neural_deformation_gradients " + project_version();
    asset.copyright = sequence.credits;
    asset.extras = tinygltf::Value(tinygltf::Value::Object{{"licences", tinygltf::Value(sequence.credits)},
                                                           {"units", tinygltf::Value(std::string("m"))},
                                                           {"up_axis", tinygltf::Value(std::string("y"))}});
    return asset;
}

}  // namespace

void write_glb(const std::string& path, const MeshSequence& sequence)
{
    const std::optional<Rig>& rig = sequence.rig;
    // Viewers blend in the order of the nodes: what is translucent comes last.
    std::vector<int> order(sequence.meshes.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_partition(order.begin(), order.end(), [&](int k) { return sequence.meshes[k].opacity >= 1.0f; });

    tinygltf::Model model;
    model.asset = asset_of(sequence);
    model.buffers.resize(1);
    model.scenes.resize(1);
    model.scenes[0].name = "body";
    model.defaultScene = 0;
    std::vector<std::vector<Points>> vertices(sequence.meshes.size());  // mesh, frame
    std::vector<int> nodes(sequence.meshes.size());
    const bool rig_alone = rig && sequence.meshes.size() == 1;
    for (int f = 0; f < (rig_alone ? 1 : sequence.num_frames); ++f) {
        std::vector<MeshFrame> frames = sequence.frame(f);
        if (rig) frames[rig->mesh_idx].vertices = rig->rest_vertices;
        if (f == 0)
            for (const int k : order) nodes[k] = add_mesh(model, sequence.meshes[k], frames[k]);
        for (std::size_t k = 0; k < frames.size(); ++k) vertices[k].push_back(frames[k].vertices);
    }
    std::vector<int> joint_nodes;
    if (rig) joint_nodes = gltf::add_rig(model, *rig, nodes[rig->mesh_idx]);
    if (sequence.num_frames > 1) {
        std::vector<MovingNode> moving_nodes;
        for (const int k : order)
            if (!rig || k != rig->mesh_idx)
                moving_nodes.push_back(add_motion(model, nodes[k], sequence.meshes[k], vertices[k]));
        std::vector<RigClip> clips = sequence.clips;
        if (clips.empty()) clips = {{"motion", 0, sequence.num_frames, sequence.frame_rate}};
        for (const RigClip& clip : clips) {
            gltf::Motion motion(model, clip);
            for (const MovingNode& moving : moving_nodes) {
                if (moving.num_targets > 0) {
                    motion.add_target_weights(moving.node, moving.num_targets);
                } else {
                    motion.add_rotations(moving.node, moving.rotations);
                    motion.add_translations(moving.node, moving.translations);
                }
            }
            if (rig) gltf::add_rig_motion(motion, *rig, nodes[rig->mesh_idx], joint_nodes);
            motion.finish();
        }
    }
    std::ostringstream stream;
    tinygltf::TinyGLTF writer;
    require(writer.WriteGltfSceneToStream(&model, stream, false, true), "{} could not be encoded as glTF", path);
    write_file(path, stream.str());
}

}  // namespace ndg
