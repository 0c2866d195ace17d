// SPDX-License-Identifier: Apache-2.0
// Binary glTF 2.0: one named node, mesh and material a mesh, vertex normals, translucent meshes alpha-blended and drawn
// last, vertex colours as COLOR_0, the credits as the asset's copyright. Several frames are an animation: of a mesh
// that moves as a rigid body (a bone) its node's rotation and translation, of every other mesh a morph target a frame.
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/provenance.h"
#include "ndg/export/mesh_sequence.h"
#include "ndg/geometry/triangle_mesh.h"

#include <tiny_gltf.h>
#include <Eigen/Geometry>

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
    if (target != 0) view.target = target;
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

int add_positions(tinygltf::Model& model, const FloatRows& positions)
{
    const int index = add_float_rows(model, positions);
    tinygltf::Accessor& accessor = model.accessors[std::size_t(index)];
    for (int k = 0; k < 3; ++k) {
        accessor.minValues.push_back(double(positions.col(k).minCoeff()));
        accessor.maxValues.push_back(double(positions.col(k).maxCoeff()));
    }
    return index;
}

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

/// Adds what an animation reads: floats, `components` a keyframe, or a value alone.
int add_keys(tinygltf::Model& model, const std::vector<float>& values, int type, int components)
{
    return add_accessor(model, values.data(), values.size() * sizeof(float), 0, TINYGLTF_COMPONENT_TYPE_FLOAT, type,
                        values.size() / std::size_t(components));
}

/// The one animation of a file.
class MotionWriter {
public:
    MotionWriter(tinygltf::Model& model, int num_frames, double frame_rate) : model_(model), num_frames_(num_frames)
    {
        animation_.name = "motion";
        std::vector<float> times;
        for (int f = 0; f < num_frames; ++f) times.push_back(float(f / frame_rate));
        times_ = add_keys(model, times, TINYGLTF_TYPE_SCALAR, 1);
        model.accessors[times_].minValues = {double(times.front())};
        model.accessors[times_].maxValues = {double(times.back())};
    }

    /// `vertices`: of all frames; the node's mesh holds the first.
    void add(int node, const ExportedMesh& mesh, const std::vector<Points>& vertices)
    {
        std::vector<Eigen::Isometry3d> motions;
        if (is_rigid(vertices, motions))
            add_rigid(node, motions);
        else
            add_targets(node, mesh, vertices);
    }
    void finish() { model_.animations.push_back(animation_); }

private:
    /// Rigid motions from the first frame by least squares (Umeyama 1991, without scale).
    static bool is_rigid(const std::vector<Points>& vertices, std::vector<Eigen::Isometry3d>& motions)
    {
        constexpr double tolerance = 2e-5;  // m
        const Eigen::Matrix3Xd first = vertices[0].transpose();
        if (first.cols() < 3) return false;
        for (const Points& frame : vertices) {
            const Eigen::Matrix3Xd moved = frame.transpose();
            Eigen::Isometry3d& motion = motions.emplace_back(Eigen::Isometry3d::Identity());
            motion.matrix() = Eigen::umeyama(first, moved, false);
            if ((motion * first - moved).colwise().norm().maxCoeff() > tolerance) return false;
        }
        return true;
    }

    void add_channel(int node, const char* path, int values)
    {
        tinygltf::AnimationSampler sampler;
        sampler.input = times_;
        sampler.output = values;
        sampler.interpolation = "LINEAR";
        tinygltf::AnimationChannel channel;
        channel.sampler = int(animation_.samplers.size());
        channel.target_node = node;
        channel.target_path = path;
        animation_.samplers.push_back(sampler);
        animation_.channels.push_back(channel);
    }

    void add_rigid(int node, const std::vector<Eigen::Isometry3d>& motions)
    {
        std::vector<float> rotations, translations;
        Eigen::Quaternionf before = Eigen::Quaternionf::Identity();
        for (const Eigen::Isometry3d& motion : motions) {
            Eigen::Quaternionf rotation(motion.linear().cast<float>());
            rotation.normalize();
            if (rotation.dot(before) < 0.0f) rotation.coeffs() *= -1.0f;  // players blend the shorter way
            before = rotation;
            rotations.insert(rotations.end(), rotation.coeffs().data(), rotation.coeffs().data() + 4);
            for (int k = 0; k < 3; ++k) translations.push_back(float(motion.translation()[k]));
        }
        add_channel(node, "rotation", add_keys(model_, rotations, TINYGLTF_TYPE_VEC4, 4));
        add_channel(node, "translation", add_keys(model_, translations, TINYGLTF_TYPE_VEC3, 3));
    }

    void add_targets(int node, const ExportedMesh& exported, const std::vector<Points>& vertices)
    {
        tinygltf::Mesh& mesh = model_.meshes[model_.nodes[node].mesh];
        const FloatRows normals = unit_normals(exported, vertices[0]);
        const int num_targets = num_frames_ - 1;
        for (int f = 1; f < num_frames_; ++f)
            mesh.primitives[0].targets.push_back(
                {{"POSITION", add_positions(model_, (vertices[f] - vertices[0]).cast<float>())},
                 {"NORMAL", add_float_rows(model_, unit_normals(exported, vertices[f]) - normals)}});
        mesh.weights.assign(std::size_t(num_targets), 0.0);
        if (weights_ < 0) {
            // At frame f target f - 1 stands alone; at the first, none.
            std::vector<float> weights(std::size_t(num_frames_ * num_targets), 0.0f);
            for (int f = 1; f < num_frames_; ++f) weights[f * num_targets + f - 1] = 1.0f;
            weights_ = add_keys(model_, weights, TINYGLTF_TYPE_SCALAR, 1);
        }
        add_channel(node, "weights", weights_);
    }

    tinygltf::Model& model_;
    tinygltf::Animation animation_;
    int num_frames_, times_ = -1, weights_ = -1;
};

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
    std::vector<std::vector<Points>> vertices(sequence.meshes.size());  // mesh, frame
    std::vector<int> nodes(sequence.meshes.size());
    for (int f = 0; f < sequence.num_frames; ++f) {
        const std::vector<MeshFrame> frames = sequence.frame(f);
        if (f == 0)
            for (const int k : order) nodes[k] = add_mesh(model, sequence.meshes[k], frames[k]);
        for (std::size_t k = 0; k < frames.size(); ++k) vertices[k].push_back(frames[k].vertices);
    }
    if (sequence.num_frames > 1) {
        MotionWriter motion(model, sequence.num_frames, sequence.frame_rate);
        for (const int k : order) motion.add(nodes[k], sequence.meshes[k], vertices[k]);
        motion.finish();
    }
    std::ostringstream stream;
    tinygltf::TinyGLTF writer;
    require(writer.WriteGltfSceneToStream(&model, stream, false, true), "{} could not be encoded as glTF", path);
    write_file(path, stream.str());
}

}  // namespace ndg
