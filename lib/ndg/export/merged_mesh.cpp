// SPDX-License-Identifier: Apache-2.0
// The formats of io/mesh.h: all meshes as one, a group each where the format has groups.
#include "ndg/export/mesh_sequence.h"
#include "ndg/io/mesh.h"

namespace ndg {

void write_merged(const std::string& path, const MeshSequence& sequence)
{
    const std::vector<MeshFrame> frames = sequence.frame(0);
    MeshFile merged;
    merged.comment = sequence.credits;
    Eigen::Index num_vertices = 0, num_triangles = 0;
    for (std::size_t k = 0; k < frames.size(); ++k) {
        num_vertices += frames[k].vertices.rows();
        num_triangles += sequence.meshes[k].triangles.rows();
    }
    merged.vertices.resize(num_vertices, 3);
    merged.triangles.resize(num_triangles, 3);
    merged.vertex_colours.resize(num_vertices, 3);
    // A mesh that lacks a scalar of another one has zeros.
    for (const MeshFrame& frame : frames)
        for (const auto& [name, values] : frame.scalars) merged.vertex_scalars[name].setZero(num_vertices);
    Eigen::Index vertex = 0, triangle = 0;
    for (std::size_t k = 0; k < frames.size(); ++k) {
        const ExportedMesh& mesh = sequence.meshes[k];
        const MeshFrame& frame = frames[k];
        const Eigen::Index vertices = frame.vertices.rows(), triangles = mesh.triangles.rows();
        merged.vertices.middleRows(vertex, vertices) = frame.vertices;
        merged.triangles.middleRows(triangle, triangles) = mesh.triangles.array() + int(vertex);
        merged.triangle_groups.insert(merged.triangle_groups.end(), std::size_t(triangles), mesh.name);
        if (frame.colours.rows() > 0)
            merged.vertex_colours.middleRows(vertex, vertices) = frame.colours;
        else
            merged.vertex_colours.middleRows(vertex, vertices).rowwise() = mesh.colour.transpose();
        for (const auto& [name, values] : frame.scalars) merged.vertex_scalars[name].segment(vertex, vertices) = values;
        vertex += vertices;
        triangle += triangles;
    }
    write_mesh(path, merged);
}

}  // namespace ndg
