// SPDX-License-Identifier: Apache-2.0
// Binary glTF 2.0: the triangles of the default scene, or of all meshes as they are stored.
#include "ndg/core/error.h"
#include "ndg/io/mesh_parts.h"

#include <tiny_gltf.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <set>

namespace ndg::mesh {
namespace {

/// The bytes of an accessor, checked to lie inside its buffer.
struct AccessorBytes {
    const unsigned char* begin = nullptr;
    std::size_t count = 0, stride = 0;
};

class GlbReader {
public:
    GlbReader(const std::string& path, const tinygltf::Model& model) : path_(path), model_(model) {}

    /// All meshes, in the coordinates of their accessors.
    void add_stored(MeshBuilder& builder) const
    {
        for (const tinygltf::Mesh& mesh : model_.meshes) add_mesh(mesh, Placement(), builder);
    }

    /// What the default scene shows; of a file without scenes what its nodes without parents do.
    void add_placed(MeshBuilder& builder)
    {
        place_nodes();
        for (const int node_idx : shown_) {
            const tinygltf::Node& node = model_.nodes[std::size_t(node_idx)];
            if (node.mesh < 0) continue;
            require_input(std::size_t(node.mesh) < model_.meshes.size(), "{}: node {}: mesh {} is not among the {}",
                          path_, node_idx, node.mesh, model_.meshes.size());
            Placement placement;
            placement.world_from_mesh = world_from_node_[std::size_t(node_idx)];
            if (node.skin >= 0) placement.world_from_skin = joint_motions(node_idx, node.skin);
            add_mesh(model_.meshes[std::size_t(node.mesh)], placement, builder);
        }
        require_input(builder.num_vertices() > 0 || model_.meshes.empty(),
                      "{}: its default scene shows none of the {} meshes", path_, model_.meshes.size());
    }

private:
    /// Where a mesh lies: by its node, or by the joints of a skin.
    struct Placement {
        Eigen::Affine3d world_from_mesh = Eigen::Affine3d::Identity();
        std::optional<std::vector<Eigen::Affine3d>> world_from_skin;  ///< of every joint, from the mesh at rest
    };

    void add_mesh(const tinygltf::Mesh& mesh, const Placement& placement, MeshBuilder& builder) const
    {
        for (const tinygltf::Primitive& primitive : mesh.primitives) add_primitive(mesh, primitive, placement, builder);
    }

    Eigen::Affine3d parent_from_node(const tinygltf::Node& node, int node_idx) const
    {
        Eigen::Affine3d transform = Eigen::Affine3d::Identity();
        if (node.matrix.size() == 16) {
            transform.matrix() = Eigen::Map<const Eigen::Matrix4d>(node.matrix.data());
        } else {
            if (node.translation.size() == 3)
                transform.translate(Eigen::Vector3d(node.translation[0], node.translation[1], node.translation[2]));
            if (node.rotation.size() == 4)
                transform.rotate(
                    Eigen::Quaterniond(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2])
                        .normalized());
            if (node.scale.size() == 3) transform.scale(Eigen::Vector3d(node.scale[0], node.scale[1], node.scale[2]));
        }
        require_input(transform.matrix().allFinite(), "{}: node {} has a place that is not finite", path_, node_idx);
        return transform;
    }

    /// world_from_node_ of all nodes, and shown_.
    void place_nodes()
    {
        const int count = static_cast<int>(model_.nodes.size());
        std::vector<int> parents(model_.nodes.size(), -1);
        const auto check_node = [&](int node_idx, const std::string& where) {
            require_input(node_idx >= 0 && node_idx < count, "{}: {}: node {} is not among the {}", path_, where,
                          node_idx, count);
        };
        for (int i = 0; i < count; ++i) {
            for (const int child : model_.nodes[std::size_t(i)].children) {
                check_node(child, fmt::format("node {}", i));
                require_input(parents[std::size_t(child)] < 0 && child != i, "{}: node {} has two parents", path_,
                              child);
                parents[std::size_t(child)] = i;
            }
        }
        std::vector<int> roots;
        for (int i = 0; i < count; ++i)
            if (parents[std::size_t(i)] < 0) roots.push_back(i);
        world_from_node_.resize(model_.nodes.size());
        const std::vector<int> placed = descend(roots, true);
        require_input(placed.size() == model_.nodes.size(), "{}: nodes are their own ancestors", path_);
        if (!model_.scenes.empty()) {
            const int scene = std::max(model_.defaultScene, 0);
            require_input(std::size_t(scene) < model_.scenes.size(), "{}: scene {} is not among the {}", path_, scene,
                          model_.scenes.size());
            roots = model_.scenes[std::size_t(scene)].nodes;
            for (const int root : roots) check_node(root, fmt::format("scene {}", scene));
        }
        shown_ = descend(roots, false);
    }

    /// The nodes below and with `roots`; fills world_from_node_ for them where wanted.
    std::vector<int> descend(const std::vector<int>& roots, bool place)
    {
        std::vector<int> nodes;
        std::set<int> seen;
        for (const int root : roots) {
            if (!seen.insert(root).second) continue;
            if (place) world_from_node_[std::size_t(root)] = parent_from_node(model_.nodes[std::size_t(root)], root);
            nodes.push_back(root);
        }
        for (std::size_t next = 0; next < nodes.size(); ++next) {
            const auto parent = std::size_t(nodes[next]);
            for (const int child : model_.nodes[parent].children) {
                if (!seen.insert(child).second) continue;
                if (place)
                    world_from_node_[std::size_t(child)] =
                        world_from_node_[parent] * parent_from_node(model_.nodes[std::size_t(child)], child);
                nodes.push_back(child);
            }
        }
        return nodes;
    }

    /// Of each joint of a skin at rest, from where the mesh is bound.
    std::vector<Eigen::Affine3d> joint_motions(int node_idx, int skin_idx) const
    {
        require_input(std::size_t(skin_idx) < model_.skins.size(), "{}: node {}: skin {} is not among the {}", path_,
                      node_idx, skin_idx, model_.skins.size());
        const tinygltf::Skin& skin = model_.skins[std::size_t(skin_idx)];
        AccessorBytes bind;
        if (skin.inverseBindMatrices >= 0) {
            bind = find_bytes(skin.inverseBindMatrices, TINYGLTF_TYPE_MAT4, 64);
            require_input(bind.count >= skin.joints.size(), "{}: skin {}: {} bind matrices of {} joints", path_,
                          skin_idx, bind.count, skin.joints.size());
        }
        std::vector<Eigen::Affine3d> motions;
        for (std::size_t j = 0; j < skin.joints.size(); ++j) {
            require_input(skin.joints[j] >= 0 && std::size_t(skin.joints[j]) < model_.nodes.size(),
                          "{}: skin {}: node {} is not among the {}", path_, skin_idx, skin.joints[j],
                          model_.nodes.size());
            motions.push_back(world_from_node_[std::size_t(skin.joints[j])]);
            if (bind.begin == nullptr) continue;
            Eigen::Matrix4f joint_from_mesh;
            std::memcpy(joint_from_mesh.data(), bind.begin + j * bind.stride, 64);
            require_input(joint_from_mesh.allFinite(), "{}: skin {}: bind matrix {} is not finite", path_, skin_idx, j);
            motions.back() = motions.back() * Eigen::Affine3d(joint_from_mesh.cast<double>());
        }
        return motions;
    }

    /// One affine motion a vertex, blended by JOINTS_0 and WEIGHTS_0, JOINTS_1 and so on.
    std::vector<Eigen::Affine3d> blended_motions(const tinygltf::Mesh& mesh, const tinygltf::Primitive& primitive,
                                                 const std::vector<Eigen::Affine3d>& joints, std::size_t count) const
    {
        std::vector<Eigen::Matrix4d> sums(count, Eigen::Matrix4d::Zero());
        std::vector<double> totals(count, 0.0);
        for (int set = 0;; ++set) {
            const auto joint_attribute = primitive.attributes.find(fmt::format("JOINTS_{}", set));
            const auto weight_attribute = primitive.attributes.find(fmt::format("WEIGHTS_{}", set));
            if (joint_attribute == primitive.attributes.end() || weight_attribute == primitive.attributes.end()) break;
            const auto indices = read_numbers(joint_attribute->second, TINYGLTF_TYPE_VEC4, 4, count);
            const auto weights = read_numbers(weight_attribute->second, TINYGLTF_TYPE_VEC4, 4, count);
            for (std::size_t i = 0; i < 4 * count; ++i) {
                if (!(weights[i] > 0)) continue;
                require_input(indices[i] < double(joints.size()),
                              "{}: mesh '{}': vertex {}: joint {} is not among the {}", path_, mesh.name, i / 4,
                              indices[i], joints.size());
                sums[i / 4] += weights[i] * joints[std::size_t(indices[i])].matrix();
                totals[i / 4] += weights[i];
            }
        }
        std::vector<Eigen::Affine3d> motions(count);
        for (std::size_t i = 0; i < count; ++i) {
            require_input(totals[i] > 0, "{}: mesh '{}': vertex {} has no weights of its skin", path_, mesh.name, i);
            motions[i].matrix() = sums[i] / totals[i];
        }
        return motions;
    }

    /// Numbers of an accessor; whole numbers that stand for shares become shares.
    std::vector<double> read_numbers(int accessor_idx, int type, std::size_t width, std::size_t count) const
    {
        const tinygltf::Accessor& found = accessor(accessor_idx);
        const int component = found.componentType;
        const std::size_t size = component == TINYGLTF_COMPONENT_TYPE_FLOAT            ? 4
                                 : component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ? 2
                                 : component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE  ? 1
                                                                                       : 0;
        require_input(size > 0, "{}: accessor {}: component type {}", path_, accessor_idx, component);
        const AccessorBytes bytes = find_bytes(accessor_idx, type, width * size);
        require_input(bytes.count == count, "{}: accessor {}: {} values of {} vertices", path_, accessor_idx,
                      bytes.count, count);
        const double unit = !found.normalized ? 1.0 : size == 2 ? 65535.0 : 255.0;
        std::vector<double> values(width * count);
        for (std::size_t i = 0; i < values.size(); ++i) {
            const unsigned char* at = bytes.begin + i / width * bytes.stride + i % width * size;
            float real = 0;
            std::uint32_t whole = 0;
            std::memcpy(size == 4 ? static_cast<void*>(&real) : &whole, at, size);
            values[i] = size == 4 ? double(real) : whole / unit;
        }
        return values;
    }

    void add_primitive(const tinygltf::Mesh& mesh, const tinygltf::Primitive& primitive, const Placement& placement,
                       MeshBuilder& builder) const
    {
        const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
        require_input(mode == TINYGLTF_MODE_TRIANGLES, "{}: mesh '{}': primitive mode {} is not triangles", path_,
                      mesh.name, mode);
        const auto position = primitive.attributes.find("POSITION");
        require_input(position != primitive.attributes.end(), "{}: mesh '{}' has no positions", path_, mesh.name);
        const auto first_vertex = static_cast<long long>(builder.num_vertices());
        const AccessorBytes points = find_bytes(position->second, TINYGLTF_TYPE_VEC3, 12);
        require_input(accessor(position->second).componentType == TINYGLTF_COMPONENT_TYPE_FLOAT,
                      "{}: accessor {}: positions of component type {} instead of float", path_, position->second,
                      accessor(position->second).componentType);
        std::vector<Eigen::Affine3d> motions;
        if (placement.world_from_skin)
            motions = blended_motions(mesh, primitive, *placement.world_from_skin, points.count);
        for (std::size_t i = 0; i < points.count; ++i) {
            Eigen::Vector3f stored;
            std::memcpy(stored.data(), points.begin + i * points.stride, 12);
            const Eigen::Affine3d& motion = motions.empty() ? placement.world_from_mesh : motions[i];
            const Eigen::Vector3d point = motion * stored.cast<double>();
            builder.add_vertex(point.x(), point.y(), point.z(),
                               fmt::format("{}: mesh '{}': vertex {}", path_, mesh.name, i));
        }
        const std::vector<long long> corners =
            primitive.indices < 0 ? count_up(points.count) : read_indices(primitive.indices);
        require_input(corners.size() % 3 == 0, "{}: mesh '{}': {} indices are not whole triangles", path_, mesh.name,
                      corners.size());
        // A mirror image turns triangles inside out.
        const bool mirrored =
            (motions.empty() ? placement.world_from_mesh : motions.front()).linear().determinant() < 0;
        for (std::size_t i = 0; i < corners.size(); i += 3) {
            for (std::size_t k = 0; k < 3; ++k)
                require_input(corners[i + k] < static_cast<long long>(points.count),
                              "{}: mesh '{}': triangle {}: vertex {} is not among the {} vertices", path_, mesh.name,
                              i / 3, corners[i + k], points.count);
            const std::size_t second = mirrored ? i + 2 : i + 1, third = mirrored ? i + 1 : i + 2;
            builder.add_polygon(
                {first_vertex + corners[i], first_vertex + corners[second], first_vertex + corners[third]}, mesh.name,
                i / 3);
        }
    }

    const tinygltf::Accessor& accessor(int accessor_idx) const
    {
        require_input(accessor_idx >= 0 && std::size_t(accessor_idx) < model_.accessors.size(),
                      "{}: accessor {} is not among the {}", path_, accessor_idx, model_.accessors.size());
        return model_.accessors[std::size_t(accessor_idx)];
    }

    AccessorBytes find_bytes(int accessor_idx, int type, std::size_t element_size) const
    {
        const tinygltf::Accessor& found = accessor(accessor_idx);
        require_input(found.type == type, "{}: accessor {}: element type {} instead of {}", path_, accessor_idx,
                      found.type, type);
        require_input(!found.sparse.isSparse, "{}: accessor {}: sparse accessors are not supported", path_,
                      accessor_idx);
        require_input(found.bufferView >= 0 && std::size_t(found.bufferView) < model_.bufferViews.size(),
                      "{}: accessor {}: buffer view {} is not among the {}", path_, accessor_idx, found.bufferView,
                      model_.bufferViews.size());
        const tinygltf::BufferView& view = model_.bufferViews[std::size_t(found.bufferView)];
        require_input(view.buffer >= 0 && std::size_t(view.buffer) < model_.buffers.size(),
                      "{}: buffer view {}: buffer {} is not among the {}", path_, found.bufferView, view.buffer,
                      model_.buffers.size());
        const std::vector<unsigned char>& data = model_.buffers[std::size_t(view.buffer)].data;
        const std::size_t stride = view.byteStride == 0 ? element_size : view.byteStride;
        const bool view_fits = view.byteOffset <= data.size() && view.byteLength <= data.size() - view.byteOffset;
        const bool accessor_fits = view_fits && found.count > 0 && stride >= element_size &&
                                   found.byteOffset <= view.byteLength &&
                                   element_size <= view.byteLength - found.byteOffset &&
                                   found.count - 1 <= (view.byteLength - found.byteOffset - element_size) / stride;
        require_input(accessor_fits, "{}: accessor {}: {} elements do not fit into its {} bytes", path_, accessor_idx,
                      found.count, view.byteLength);
        return {data.data() + view.byteOffset + found.byteOffset, found.count, stride};
    }

    static std::vector<long long> count_up(std::size_t count)
    {
        std::vector<long long> values(count);
        for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<long long>(i);
        return values;
    }

    std::vector<long long> read_indices(int accessor_idx) const
    {
        const int component = accessor(accessor_idx).componentType;
        const bool known = component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                           component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                           component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
        require_input(known, "{}: accessor {}: indices of component type {}", path_, accessor_idx, component);
        const std::size_t size = component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE    ? 1
                                 : component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ? 2
                                                                                       : 4;
        const AccessorBytes bytes = find_bytes(accessor_idx, TINYGLTF_TYPE_SCALAR, size);
        std::vector<long long> values(bytes.count);
        for (std::size_t i = 0; i < bytes.count; ++i) {
            std::uint32_t value = 0;  // glTF is little endian, and so is every machine this is built for
            std::memcpy(&value, bytes.begin + i * bytes.stride, size);
            values[i] = value;
        }
        return values;
    }

    const std::string& path_;
    const tinygltf::Model& model_;
    std::vector<Eigen::Affine3d> world_from_node_;
    std::vector<int> shown_;  ///< nodes
};

}  // namespace

MeshFile read_glb(const std::string& path, std::string bytes, const MeshReading& reading)
{
    const std::string_view content = bytes;
    require_input(content.size() <= std::numeric_limits<unsigned int>::max(), "{}: is larger than 4 GiB", path);
    // tinygltf trusts the lengths in the header, so they are checked before it reads on.
    std::uint32_t header[3] = {};
    require_input(content.size() >= 20 && content.substr(0, 4) == "glTF", "{}: is not a binary glTF file", path);
    std::memcpy(header, content.data(), sizeof header);
    require_input(header[1] == 2, "{}: glTF version {} instead of 2", path, header[1]);
    require_input(header[2] <= content.size(), "{}: truncated, {} bytes instead of {}", path, content.size(),
                  header[2]);
    tinygltf::Model model;
    std::string error, warning;
    bool loaded = false;
    try {
        tinygltf::TinyGLTF loader;
        loaded = loader.LoadBinaryFromMemory(&model, &error, &warning,
                                             reinterpret_cast<const unsigned char*>(content.data()),
                                             static_cast<unsigned int>(content.size()), "", tinygltf::REQUIRE_VERSION);
    } catch (const std::exception& exception) {
        error = exception.what();
    }
    for (char& c : error)
        if (c == '\n') c = ' ';
    require_input(loaded, "{}: not readable as glTF: {}", path, error.empty() ? "unknown reason" : error);
    require_input(model.extensionsRequired.empty(), "{}: needs the extension '{}'", path,
                  model.extensionsRequired.empty() ? "" : model.extensionsRequired.front());
    MeshBuilder builder(path, reading.drop_invalid);
    GlbReader reader(path, model);
    if (reading.placed) {
        reader.add_placed(builder);
    } else {
        reader.add_stored(builder);
    }
    return std::move(builder).finish("triangle", 0);
}

}  // namespace ndg::mesh
