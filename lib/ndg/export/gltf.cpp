// SPDX-License-Identifier: Apache-2.0
// Binary glTF 2.0: one named node, mesh and material a mesh, vertex normals, translucent meshes alpha-blended and drawn
// last, vertex colours as COLOR_0, the credits as the asset's copyright.
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/provenance.h"
#include "ndg/export/mesh_sequence.h"
#include "ndg/geometry/triangle_mesh.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <sstream>

namespace ndg {
namespace {

using FloatRows = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// Appends raw data to the one buffer and describes it; returns the accessor's index.
int add_accessor(tinygltf::Model& model, const void* data, std::size_t bytes, int target, int component_type, int type,
                 std::size_t count)
{
    std::vector<unsigned char>& buffer = model.buffers[0].data;
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = buffer.size();
    view.byteLength = bytes;
    view.target = target;
    buffer.resize(buffer.size() + bytes);
    std::memcpy(buffer.data() + view.byteOffset, data, bytes);
    tinygltf::Accessor accessor;
    accessor.bufferView = int(model.bufferViews.size());
    accessor.componentType = component_type;
    accessor.type = type;
    accessor.count = count;
    model.bufferViews.push_back(view);
    model.accessors.push_back(accessor);
    return int(model.accessors.size()) - 1;
}

int add_float_rows(tinygltf::Model& model, const FloatRows& rows)
{
    return add_accessor(model, rows.data(), std::size_t(rows.size()) * sizeof(float), TINYGLTF_TARGET_ARRAY_BUFFER,
                        TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, std::size_t(rows.rows()));
}

int add_positions(tinygltf::Model& model, const MeshFrame& frame)
{
    const FloatRows positions = frame.vertices.cast<float>();
    const int index = add_float_rows(model, positions);
    tinygltf::Accessor& accessor = model.accessors[std::size_t(index)];
    for (int k = 0; k < 3; ++k) {
        accessor.minValues.push_back(double(positions.col(k).minCoeff()));
        accessor.maxValues.push_back(double(positions.col(k).maxCoeff()));
    }
    return index;
}

int add_normals(tinygltf::Model& model, const ExportedMesh& mesh, const MeshFrame& frame)
{
    FloatRows normals = vertex_normals(frame.vertices, mesh.triangles).cast<float>();
    for (Eigen::Index i = 0; i < normals.rows(); ++i)
        if (normals.row(i).squaredNorm() < 0.5f) normals.row(i) << 0.0f, 1.0f, 0.0f;  // glTF asks for unit length
    return add_float_rows(model, normals);
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

void add_mesh(tinygltf::Model& model, const ExportedMesh& exported, const MeshFrame& frame)
{
    const bool coloured = frame.colours.rows() > 0;
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    primitive.attributes["POSITION"] = add_positions(model, frame);
    primitive.attributes["NORMAL"] = add_normals(model, exported, frame);
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
    model.meshes.push_back(mesh);
    model.scenes[0].nodes.push_back(int(model.nodes.size()));
    model.nodes.push_back(node);
}

}  // namespace

void write_glb(const std::string& path, const MeshSequence& sequence)
{
    // Viewers blend in the order of the nodes: what is translucent comes last.
    std::vector<int> order(sequence.meshes.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_partition(order.begin(), order.end(), [&](int k) { return sequence.meshes[k].opacity >= 1.0f; });

    tinygltf::Model model;
    model.asset.version = "2.0";
    model.asset.generator = "neural_deformation_gradients " + project_version();
    model.asset.copyright = sequence.credits;
    model.buffers.resize(1);
    model.scenes.resize(1);
    model.scenes[0].name = "body";
    model.defaultScene = 0;
    const std::vector<MeshFrame> frames = sequence.frame(0);
    for (const int k : order) add_mesh(model, sequence.meshes[k], frames[k]);
    std::ostringstream stream;
    tinygltf::TinyGLTF writer;
    require(writer.WriteGltfSceneToStream(&model, stream, false, true), "{} could not be encoded as glTF", path);
    write_file(path, stream.str());
}

}  // namespace ndg
