// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/io/mesh.h"

#include <cmath>
#include <cstdint>
#include <iterator>
#include <sstream>

namespace ndg {
namespace {

template <typename T>
void append_bytes(std::string& content, T value)
{
    content.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void append_position(std::string& content, const Eigen::RowVector3d& position)
{
    for (int k = 0; k < 3; ++k) append_bytes(content, static_cast<float>(position[k]));
}

/// Every line of the comment after `mark`.
std::string comment_lines(const std::string& comment, const std::string& mark)
{
    std::string lines;
    std::istringstream stream(comment);
    for (std::string line; std::getline(stream, line);) lines += mark + line + "\n";
    return lines;
}

std::string obj_content(const MeshFile& mesh)
{
    fmt::memory_buffer buffer;
    auto out = std::back_inserter(buffer);
    fmt::format_to(out, "{}", comment_lines(mesh.comment, "# "));
    for (int i = 0; i < mesh.vertices.rows(); ++i)
        fmt::format_to(out, "v {:.9g} {:.9g} {:.9g}\n", mesh.vertices(i, 0), mesh.vertices(i, 1), mesh.vertices(i, 2));
    std::string group;
    for (int i = 0; i < mesh.triangles.rows(); ++i) {
        if (!mesh.triangle_groups.empty() && mesh.triangle_groups[i] != group) {
            group = mesh.triangle_groups[i];
            fmt::format_to(out, "g {}\n", group);
        }
        fmt::format_to(out, "f {} {} {}\n", mesh.triangles(i, 0) + 1, mesh.triangles(i, 1) + 1,
                       mesh.triangles(i, 2) + 1);
    }
    return fmt::to_string(buffer);
}

std::string off_content(const MeshFile& mesh)
{
    fmt::memory_buffer buffer;
    auto out = std::back_inserter(buffer);
    fmt::format_to(out, "OFF\n{}{} {} 0\n", comment_lines(mesh.comment, "# "), mesh.vertices.rows(),
                   mesh.triangles.rows());
    for (int i = 0; i < mesh.vertices.rows(); ++i)
        fmt::format_to(out, "{:.9g} {:.9g} {:.9g}\n", mesh.vertices(i, 0), mesh.vertices(i, 1), mesh.vertices(i, 2));
    for (int i = 0; i < mesh.triangles.rows(); ++i)
        fmt::format_to(out, "3 {} {} {}\n", mesh.triangles(i, 0), mesh.triangles(i, 1), mesh.triangles(i, 2));
    return fmt::to_string(buffer);
}

std::string ply_content(const MeshFile& mesh)
{
    const bool coloured = mesh.vertex_colours.rows() > 0;
    std::string content = "ply\nformat binary_little_endian 1.0\n" + comment_lines(mesh.comment, "comment ");
    content +=
        fmt::format("element vertex {}\nproperty float x\nproperty float y\nproperty float z\n", mesh.vertices.rows());
    if (coloured) content += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    for (const auto& [name, values] : mesh.vertex_scalars) content += fmt::format("property float {}\n", name);
    content +=
        fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n", mesh.triangles.rows());
    for (int i = 0; i < mesh.vertices.rows(); ++i) {
        append_position(content, mesh.vertices.row(i));
        for (int k = 0; coloured && k < 3; ++k)
            append_bytes(content, std::uint8_t(std::lround(255.0f * mesh.vertex_colours(i, k))));
        for (const auto& [name, values] : mesh.vertex_scalars) append_bytes(content, values[i]);
    }
    for (int i = 0; i < mesh.triangles.rows(); ++i) {
        append_bytes(content, std::uint8_t{3});
        for (int k = 0; k < 3; ++k) append_bytes(content, std::int32_t(mesh.triangles(i, k)));
    }
    return content;
}

std::string stl_content(const MeshFile& mesh)
{
    std::string content(80, '\0');
    append_bytes(content, std::uint32_t(mesh.triangles.rows()));
    for (int i = 0; i < mesh.triangles.rows(); ++i) {
        const Eigen::RowVector3d a = mesh.vertices.row(mesh.triangles(i, 0));
        const Eigen::RowVector3d b = mesh.vertices.row(mesh.triangles(i, 1));
        const Eigen::RowVector3d c = mesh.vertices.row(mesh.triangles(i, 2));
        append_position(content, (b - a).cross(c - a).stableNormalized());
        for (const auto& corner : {a, b, c}) append_position(content, corner);
        append_bytes(content, std::uint16_t{0});
    }
    return content;
}

void check_mesh(const std::string& path, const MeshFile& mesh)
{
    const Eigen::Index num_vertices = mesh.vertices.rows();
    for (int i = 0; i < num_vertices; ++i) {
        for (int k = 0; k < 3; ++k) {
            const double value = mesh.vertices(i, k);
            require(std::isfinite(static_cast<float>(value)), "{}: coordinate {} of vertex {} is not finite: {}", path,
                    k, i, value);
        }
    }
    for (int i = 0; i < mesh.triangles.rows(); ++i) {
        for (int k = 0; k < 3; ++k) {
            const int vertex = mesh.triangles(i, k);
            require(vertex >= 0 && vertex < num_vertices, "{}: vertex {} of triangle {} is not among the {} vertices",
                    path, vertex, i, num_vertices);
        }
    }
    const Eigen::Index num_colours = mesh.vertex_colours.rows(), num_groups = mesh.triangle_groups.size();
    require(num_colours == 0 || num_colours == num_vertices, "{}: {} colours for {} vertices", path, num_colours,
            num_vertices);
    require(num_colours == 0 || (mesh.vertex_colours.minCoeff() >= 0.0f && mesh.vertex_colours.maxCoeff() <= 1.0f),
            "{}: a colour lies outside [0, 1]", path);
    require(num_groups == 0 || num_groups == mesh.triangles.rows(), "{}: {} groups for {} triangles", path, num_groups,
            mesh.triangles.rows());
    for (const auto& [name, values] : mesh.vertex_scalars)
        require(values.size() == num_vertices && values.allFinite(), "{}: {} is not one finite value a vertex", path,
                name);
}

}  // namespace

void write_mesh(const std::string& path, const MeshFile& mesh)
{
    check_mesh(path, mesh);
    const std::string extension = lower_extension(path);
    if (extension == ".obj") return write_file(path, obj_content(mesh));
    if (extension == ".off") return write_file(path, off_content(mesh));
    if (extension == ".ply") return write_file(path, ply_content(mesh));
    if (extension == ".stl") return write_file(path, stl_content(mesh));
    throw InputError(fmt::format("{}: unknown mesh format '{}', expected .obj, .ply, .off or .stl", path, extension));
}

void write_mesh(const std::string& path, const Eigen::Ref<const Points>& vertices,
                const Eigen::Ref<const Triangles>& triangles)
{
    MeshFile mesh;
    mesh.vertices = vertices;
    mesh.triangles = triangles;
    write_mesh(path, mesh);
}

}  // namespace ndg
