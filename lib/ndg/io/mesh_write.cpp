// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/io/mesh.h"
#include "ndg/io/mesh_parts.h"

#include <cmath>
#include <cstdint>
#include <iterator>

namespace ndg {
namespace {

using VerticesRef = Eigen::Ref<const Points>;
using TrianglesRef = Eigen::Ref<const Triangles>;

template <typename T>
void append_bytes(std::string& content, T value)
{
    content.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void append_position(std::string& content, const Eigen::RowVector3d& position)
{
    for (int k = 0; k < 3; ++k) append_bytes(content, static_cast<float>(position[k]));
}

std::string obj_content(const VerticesRef& vertices, const TrianglesRef& triangles)
{
    fmt::memory_buffer buffer;
    auto out = std::back_inserter(buffer);
    for (Eigen::Index i = 0; i < vertices.rows(); ++i) {
        fmt::format_to(out, "v {:.9g} {:.9g} {:.9g}\n", vertices(i, 0), vertices(i, 1), vertices(i, 2));
    }
    for (Eigen::Index i = 0; i < triangles.rows(); ++i) {
        fmt::format_to(out, "f {} {} {}\n", triangles(i, 0) + 1, triangles(i, 1) + 1, triangles(i, 2) + 1);
    }
    return fmt::to_string(buffer);
}

std::string off_content(const VerticesRef& vertices, const TrianglesRef& triangles)
{
    fmt::memory_buffer buffer;
    auto out = std::back_inserter(buffer);
    fmt::format_to(out, "OFF\n{} {} 0\n", vertices.rows(), triangles.rows());
    for (Eigen::Index i = 0; i < vertices.rows(); ++i) {
        fmt::format_to(out, "{:.9g} {:.9g} {:.9g}\n", vertices(i, 0), vertices(i, 1), vertices(i, 2));
    }
    for (Eigen::Index i = 0; i < triangles.rows(); ++i) {
        fmt::format_to(out, "3 {} {} {}\n", triangles(i, 0), triangles(i, 1), triangles(i, 2));
    }
    return fmt::to_string(buffer);
}

std::string ply_content(const VerticesRef& vertices, const TrianglesRef& triangles)
{
    std::string content = fmt::format(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float "
        "z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        vertices.rows(), triangles.rows());
    for (Eigen::Index i = 0; i < vertices.rows(); ++i) append_position(content, vertices.row(i));
    for (Eigen::Index i = 0; i < triangles.rows(); ++i) {
        append_bytes(content, std::uint8_t{3});
        for (int k = 0; k < 3; ++k) append_bytes(content, static_cast<std::int32_t>(triangles(i, k)));
    }
    return content;
}

std::string stl_content(const VerticesRef& vertices, const TrianglesRef& triangles)
{
    std::string content(80, '\0');
    append_bytes(content, static_cast<std::uint32_t>(triangles.rows()));
    for (Eigen::Index i = 0; i < triangles.rows(); ++i) {
        const Eigen::RowVector3d a = vertices.row(triangles(i, 0));
        const Eigen::RowVector3d b = vertices.row(triangles(i, 1));
        const Eigen::RowVector3d c = vertices.row(triangles(i, 2));
        append_position(content, (b - a).cross(c - a).stableNormalized());
        for (const auto& corner : {a, b, c}) append_position(content, corner);
        append_bytes(content, std::uint16_t{0});
    }
    return content;
}

}  // namespace

void write_mesh(const std::string& path, const VerticesRef& vertices, const TrianglesRef& triangles)
{
    for (Eigen::Index i = 0; i < vertices.rows(); ++i) {
        for (int k = 0; k < 3; ++k) {
            const double value = vertices(i, k);
            require(std::isfinite(static_cast<float>(value)), "{}: coordinate {} of vertex {} is not finite: {}", path,
                    k, i, value);
        }
    }
    for (Eigen::Index i = 0; i < triangles.rows(); ++i) {
        for (int k = 0; k < 3; ++k) {
            const int vertex = triangles(i, k);
            require(vertex >= 0 && vertex < vertices.rows(),
                    "{}: vertex {} of triangle {} is not among the {} vertices", path, vertex, i, vertices.rows());
        }
    }
    const std::string extension = mesh::lower_extension(path);
    if (extension == ".obj") return write_file(path, obj_content(vertices, triangles));
    if (extension == ".off") return write_file(path, off_content(vertices, triangles));
    if (extension == ".ply") return write_file(path, ply_content(vertices, triangles));
    if (extension == ".stl") return write_file(path, stl_content(vertices, triangles));
    throw InputError(fmt::format("{}: unknown mesh format '{}', expected .obj, .ply, .off or .stl", path, extension));
}

}  // namespace ndg
