// SPDX-License-Identifier: Apache-2.0
// Binary glTF 2.0: the triangles of all meshes, in the coordinates of their accessors.
#include "ndg/core/error.h"
#include "ndg/io/mesh_parts.h"

#include <tiny_gltf.h>

#include <cstdint>
#include <cstring>
#include <limits>

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

    void add_primitive(const tinygltf::Mesh& mesh, const tinygltf::Primitive& primitive, MeshBuilder& builder) const
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
        for (std::size_t i = 0; i < points.count; ++i) {
            float xyz[3];
            std::memcpy(xyz, points.begin + i * points.stride, sizeof xyz);
            builder.add_vertex(double(xyz[0]), double(xyz[1]), double(xyz[2]),
                               fmt::format("{}: mesh '{}': vertex {}", path_, mesh.name, i));
        }
        const std::vector<long long> corners =
            primitive.indices < 0 ? count_up(points.count) : read_indices(primitive.indices);
        require_input(corners.size() % 3 == 0, "{}: mesh '{}': {} indices are not whole triangles", path_, mesh.name,
                      corners.size());
        for (std::size_t i = 0; i < corners.size(); i += 3) {
            for (std::size_t k = 0; k < 3; ++k)
                require_input(corners[i + k] < static_cast<long long>(points.count),
                              "{}: mesh '{}': triangle {}: vertex {} is not among the {} vertices", path_, mesh.name,
                              i / 3, corners[i + k], points.count);
            builder.add_polygon(
                {first_vertex + corners[i], first_vertex + corners[i + 1], first_vertex + corners[i + 2]}, mesh.name,
                i / 3);
        }
    }

private:
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
};

}  // namespace

MeshFile read_glb(const std::string& path, std::string_view content)
{
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
    MeshBuilder builder(path);
    const GlbReader reader(path, model);
    for (const tinygltf::Mesh& mesh : model.meshes)
        for (const tinygltf::Primitive& primitive : mesh.primitives) reader.add_primitive(mesh, primitive, builder);
    return std::move(builder).finish("triangle", 0);
}

}  // namespace ndg::mesh
